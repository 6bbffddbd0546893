"""Makes text from peers, files and libraries safe for output: it controls no terminal and fits on a line."""

from __future__ import annotations

import errno
import json
import re
from collections.abc import Iterable, Sequence

# Control characters except line ends and tabs, invisible characters, and those that change the direction of
# writing. Also lone surrogates (from invalid UTF-8), which the encoding of a terminal rejects.
_STEERING = re.compile(
    "[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\xad\\u061c\\u180e\\u200b-\\u200f\\u2028-\\u202e\\u2060-\\u206f"
    "\\ud800-\\udfff\\ufeff\\ufff9-\\ufffb\\U000e0000-\\U000e007f]"
)


def escape_text(text: str) -> str:
    """Return the text with its lines and tabs; other control characters are escaped as in JSON."""
    if text.isprintable():
        return text
    return _STEERING.sub(lambda found: json.dumps(found[0])[1:-1], text)


def escape_line(text: str, max_chars: int | None = None) -> str:
    """Return the text as one line, with line ends and tabs escaped; `...` ends one that was too long."""
    # Escaping never shortens a text, so characters beyond the limit are not needed.
    escaped = text if max_chars is None else text[: max_chars + 1]
    if not escaped.isprintable():
        escaped = escape_text(escaped).replace("\n", "\\n").replace("\t", "\\t")
    return escaped if max_chars is None or len(escaped) <= max_chars else f"{escaped[: max_chars - 3]}..."


def fold_line(text: str) -> str:
    """Return the text as one line, with one space for each run of white space."""
    return escape_line(" ".join(text.split()))


def first_line(error: Exception) -> str:
    """Return the first line of a library's error, which may quote a whole file."""
    return str(error).split("\n", 1)[0][:200]


_WRITE_STEPS = {
    errno.ENOSPC: "free some space on its disk",
    errno.EDQUOT: "free some space on its disk",
    errno.EFBIG: "choose a disk that accepts larger files",
    errno.EISDIR: "give a file in this folder",
    errno.EEXIST: "choose another name",
}
_READ_STEPS = {
    errno.EACCES: "make it readable for this user",
    errno.EPERM: "make it readable for this user",
    errno.EIO: "check its disk",
    errno.EISDIR: "give a file in this folder",
}


def write_failure(path: object, error: Exception) -> str:
    """Return why a file or folder cannot be written, and the next step."""
    reason, number = _reason(error)
    # SQLite's errors have no number.
    step = _WRITE_STEPS.get(errno.ENOSPC if "is full" in reason else number, "choose a writable folder")
    return f"cannot write {path}: {reason}; {step}"


def read_failure(path: object, error: Exception) -> str:
    """Return why a file cannot be read, and the next step."""
    reason, number = _reason(error)
    return f"cannot read {path}: {reason}; {_READ_STEPS.get(number, 'check the path')}"


def _reason(error: Exception) -> tuple[str, int]:
    reason = getattr(error, "strerror", None) or fold_line(str(error))
    return reason, getattr(error, "errno", None) or 0


def counted(number: int, noun: str) -> str:
    """Return the number with its noun, such as `1 byte` and `2 bytes`."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def listed(texts: Sequence[str], limit: int) -> str:
    """Return texts with commas, at most `limit` of them, such as `a, b and 3 more`."""
    more = len(texts) - limit
    return ", ".join(texts[:limit]) + (f" and {more} more" if more > 0 else "")


def show_endpoint(host: str, port: int) -> str:
    """Return a host and port as users write them, an IPv6 host in brackets."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def misfit_text(number: int) -> str:
    """Return `1 message does not fit its type` or `2 messages do not fit their type`."""
    return f"{counted(number, 'message')} {'does not fit its' if number == 1 else 'do not fit their'} type"


def did_you_mean(name: str, known: Iterable[str], *, prefix: str = "", then: str = "") -> str:
    """Return `did you mean X?` with the most similar of the known names; empty if none is similar.

    `prefix` completes the similar name, and `then` follows the question.
    """
    from difflib import get_close_matches

    near = get_close_matches(name, list(known), n=1)
    return f"did you mean {prefix}{near[0]}?{then}" if near else ""


def unpublished_warning(topic: str, published: Iterable[str]) -> str:
    """Return rostopic's warning that no node publishes a topic yet, with the most similar published one."""
    hint = did_you_mean(topic.partition("[")[0], published)
    return f"WARNING: topic [{topic}] does not appear to be published yet{hint and f'; {hint}'}"


def unknown_topic(topic: str, known: Iterable[str]) -> str:
    """Return the error for a topic without publishers and subscribers, with the most similar known topic."""
    hint = did_you_mean(topic, known) or "`rostether topic list` shows all topics"
    return f"topic {topic} has no publisher and no subscriber; {hint}"
