"""Improves the compiler's output: paths as the user typed them, and hints on beginners' errors."""

from __future__ import annotations

import os
import re
import unicodedata
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

from rostether.firmware.cpp_tokens import tokenize
from rostether.firmware.ino import read_ino
from rostether.firmware.sketch import Sketch
from rostether.msgdef.registry import Registry

_MISSING_HEADER = re.compile(r"fatal error: (\S+): No such file or directory")
# The quotes depend on the locale.
_UNDECLARED = re.compile("['\u2018](\\w+)['\u2019] was not declared")
# Lines with a second directive or code after an #include, and with setup() or loop() after a `//`.
_JOINED = re.compile(
    r"^[ \t]*#[ \t]*include[ \t]*(?:<[^<>\n]+>|\"[^\"\n]+\")[ \t]*(?P<rest>(?!//|/\*)\S.*)$"
    r"|^[ \t]*#[ \t]*define[ \t].*?(?P<second>#[ \t]*(?:include|define)[ \t].*)$"
    r"|^[^\"\n]*//.*?(?P<code>void[ \t]+(?:setup|loop)[ \t]*\(.*)$",
    re.MULTILINE,
)
# Errors of the compiler that beginners do not understand.
_HINTS = (
    (
        re.compile(r"conver(?:t|sion).* to .(?:const )?ros::Msg\s*[*&]"),
        "generated messages are not ros::Msg: make the function or class a template of the message's class,"
        " such as template <class M> void send(const M* message)",
    ),
    (
        re.compile(r"cannot convert .const __FlashStringHelper\s*\*"),
        'a field of a message needs a text in RAM: remove F(). Logs accept it: nh.loginfo(F("..."))',
    ),
    (
        re.compile("(?:convert|from) ['\u2018]String(?:SumHelper)?['\u2019] to .*const char\\*"),
        "keep the String until the message is sent, and assign its text: String text = ...; message.data ="
        " text.c_str();",
    ),
)
# Packages of messages have such names, with types in camel case; folders of libraries rarely do.
_TYPE_HEADER = re.compile(r"(?:\w+_(?:msgs|srvs)/\w+|[a-z][a-z0-9_]*/[A-Z]\w*)\.h")
# Headers that no library contains.
_OF_ANOTHER_CORE = {
    "WProgram.h": "include <Arduino.h> instead, its name since Arduino 1.0",
    "ESP8266WiFi.h": "it belongs to the core of the ESP8266; build with --board esp8266",
}

# More errors of this kind do not help: all of them come from the same pasted page.
MAX_REPORTED = 8

_PLAIN = {
    **dict.fromkeys("\u201c\u201d\u201e\u201f\u00ab\u00bb\u2033", '"'),
    **dict.fromkeys("\u2018\u2019\u201a\u201b\u2032\u00b4", "'"),
    **dict.fromkeys("\u2010\u2011\u2012\u2013\u2014\u2212", "-"),
    **dict.fromkeys("\u00a0\u2002\u2003\u2007\u2009\u200a\u202f\u3000", "a space"),
    **dict.fromkeys("\u200b\u200c\u200d\u2060\ufeff\u00ad", "nothing"),
    "\u2026": "...",
    "\uff1b": ";",
    "\u037e": ";",
    "\u2217": "*",
    "\u00d7": "*",
    "\u2039": "<",
    "\u203a": ">",
}


def explain(output: str, sketch: Sketch, skipped: Sequence[str] = ()) -> str:
    """Return a compiler's output with added hints in the same format.

    `skipped` has the reasons why messages could not be generated; it is shown if a header is missing.
    """
    lines = []
    if "stray" in output or "missing terminating" in output or "expects" in output:
        for path in [*sketch.inos, *sketch.sources]:
            lines += typographic_errors(read_ino(path).text, str(path))
    if "error" in output or "undefined reference" in output:
        for path in [*sketch.inos, *sketch.sources]:
            lines += _joined_lines(read_ino(path).text, str(path))
    lines += output.splitlines()
    lines += [
        f"note: {name} is a pin of the OpenCR; build with --board opencr, or name a pin here: -D {name}=13"
        for name in dict.fromkeys(_UNDECLARED.findall(output))
        if name.startswith("BDPIN_")
    ]
    lines += [f"note: {hint}" for pattern, hint in _HINTS if pattern.search(output)]
    missing = dict.fromkeys(_MISSING_HEADER.findall(output))
    lines += [_explain_header(header) for header in missing]
    lines += [f"note: {each}" for each in skipped if missing]
    text = "".join(f"{line}\n" for line in lines)
    return _shorten(text, sketch.folder)


def _joined_lines(text: str, path: str) -> list[str]:
    """Return an error for each line that joins several lines, as copy buttons of web pages do."""
    found = []
    for match in _JOINED.finditer(text):
        group = next(name for name in ("rest", "second", "code") if match[name])
        location = _location(path, text, match.start(group))
        what = "a web page joined several lines into this one; start a new line before"
        found.append(f"{location}: error: {what} `{match[group][:30].strip()}`")
    return found[:MAX_REPORTED]


def _explain_header(header: str) -> str:
    if advice := _OF_ANOTHER_CORE.get(header):
        return f"note: this board has no {header}: {advice}"
    if _TYPE_HEADER.fullmatch(header):
        registry = Registry.from_environment()
        known = [f"{name}.h" for name in (*registry.messages(), *registry.services())]
        if near := get_close_matches(header, known, n=1, cutoff=0.8):
            return f"note: no package contains {header}; did you mean {near[0]}?"
        return f"note: no package contains {header}; give the folder of its package with --msg-path DIR"
    return f"note: no library contains {header}; give the folder of the library with --library DIR"


def _shorten(text: str, folder: Path) -> str:
    """Write paths below the current folder as relative paths, as the user typed them."""
    try:
        prefix = os.path.relpath(folder)
    except (ValueError, OSError):
        return text
    if prefix.startswith(".."):
        return text
    return text.replace(f"{folder}{os.sep}", "" if prefix == "." else f"{prefix}{os.sep}")


def typographic_errors(text: str, path: str) -> list[str]:
    """Return errors that name the first typographic characters outside comments and complete strings."""
    found: list[str] = []
    for token in tokenize(text):
        if token.kind == "comment" or (token.kind in ("string", "char") and _is_complete(token.text)):
            continue
        for offset, character in enumerate(token.text, token.offset):
            if character in _PLAIN and len(found) < MAX_REPORTED:
                name = unicodedata.name(character, "").lower() or f"character U+{ord(character):04X}"
                shown = f"{character} " if character.isprintable() and not character.isspace() else ""
                found.append(
                    f"{_location(path, text, offset)}: error: {shown}({name}) comes from a web page or PDF; "
                    f"type {_PLAIN[character]} instead"
                )
    return found


def _location(path: str, text: str, offset: int) -> str:
    """Return a place in the compiler's format; lines and columns count from 1."""
    line, column = text.count("\n", 0, offset) + 1, offset - text.rfind("\n", 0, offset)
    return f"{path}:{line}:{column}"


def _is_complete(text: str) -> bool:
    return len(text) > 1 and text[-1] == text[text.find(text[-1])] and text.find(text[-1]) != len(text) - 1
