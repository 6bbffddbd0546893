"""Advice on what to write instead of a text that cannot be read as a link address."""

from __future__ import annotations

import re
import shlex

MAX_PORT = 65535
WINDOWS_PORT = re.compile(r"(?:\\\\\.\\)?COM[0-9]+", re.IGNORECASE)

_HOST_PORT = re.compile(r"[^\s:/]+:[0-9]{1,5}")
_IPV4 = re.compile(r"[0-9]{1,3}(?:\.[0-9]{1,3}){3}")
# `/dev/ttyACM0:115200`, as other programs write it.
_PORT_AND_BAUD = re.compile(r"(.*[^:,@])[:,@]([1-9][0-9]{2,6})")
_SKETCH_SUFFIXES = (".ino", ".elf", ".hex")


def address_advice(text: str) -> str | None:
    """Return what to write instead of a text without a link type, None for an unknown link type."""
    if (meant := baud_option(text)) is not None:
        return f"write {meant}"
    if _HOST_PORT.fullmatch(text):
        return f"write tcp://{text}?connect=yes to connect there, or tcp://{text} to listen there"
    if ":" in text:
        return None
    if is_number(text):
        baud = f"for a baud rate, write it after the port: /dev/ttyACM0?baud={text}"
        listening = f"; to listen on that TCP port, write tcp://:{text}"
        return baud + (listening if int(text) <= MAX_PORT else "")
    if _IPV4.fullmatch(text):
        return (
            "boards connect to this machine: write tcp://:11411, and give them this machine's address; "
            f"to connect to a board, write tcp://{text}:PORT?connect=yes"
        )
    if text.lower().endswith(_SKETCH_SUFFIXES):
        return sketch_advice(text)
    example = f"/dev/{text}" if text.startswith(("tty", "cu.")) else "/dev/ttyACM0"
    return f"write a serial port with its path, such as {example} (`rostether ports` lists them)"


def baud_option(text: str) -> str | None:
    """Return the address that is meant by a port and a baud rate such as ttyACM0:115200, None for others."""
    match = _PORT_AND_BAUD.fullmatch(text)
    if match is None or not ("tty" in match[1] or "/cu." in match[1] or WINDOWS_PORT.fullmatch(match[1])):
        return None
    folder = "/dev/" if match[1].startswith("tty") else ""
    return f"{folder}{match[1]}?baud={match[2]}"


def sketch_advice(text: str) -> str:
    """Return what to do with a sketch where a link address belongs."""
    command = f"rostether flash {shlex.quote(text)}"
    return f"write {shlex.quote(f'sim:{text}')} for a simulated board; `{command}` flashes and serves a board"


def is_number(text: str) -> bool:
    """Return whether a text is a whole number of a length that Python converts."""
    return text.isascii() and text.isdigit() and len(text) <= 20
