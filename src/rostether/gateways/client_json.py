"""JSON of clients: parses it, also with many values, and shows parts of it in errors.

The parser of the standard library blocks other threads until it has finished: half a second for 10 MB of
numbers.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from itertools import islice
from json import JSONDecodeError, JSONDecoder
from json.decoder import JSONArray  # type: ignore[attr-defined]  # not in the stubs
from json.scanner import py_make_scanner  # type: ignore[attr-defined]
from typing import Any, Final

from rostether.errors import RemoteProtocolError
from rostether.mechanisms.text import escape_line

# The limit of lists and objects in one message. Garbage collection looks at each.
MAX_CONTAINERS: Final = 1 << 18

# With more values, parsing takes 20 ms and more.
MANY_VALUES: Final = 1 << 16

# Shorter texts are not worth counting: they have at most a thousand values.
_SHORT_CHARACTERS: Final = 2 << 10

# The largest integer of a field has 20 digits. The time to parse one grows with the square of its digits.
_MAX_DIGITS: Final = 64

# Most of a large message is lists of numbers: this many are parsed at once, in less than a millisecond.
_NUMBERS: Final = re.compile(r"(?:[ \t\r\n]*-?\d[\d.eE+-]{0,63}[ \t\r\n]*,){1,4096}")

# A longer value would hide the rest of the error.
_MAX_SHOWN = 80
_SHOWN_DEPTH = 3
_REST = "..."


def _integer(digits: str) -> int:
    if len(digits) > _MAX_DIGITS:
        raise ValueError(f"an integer has more than {_MAX_DIGITS} digits")
    return int(digits)


# Shorter texts have too few digits to take longer than 10 ms. The check of each integer takes 0.1 µs.
_MANY_CHARACTERS: Final = 256 << 10
_CHECKING_DECODER: Final = JSONDecoder(parse_int=_integer)


def count_values(text: str) -> int:
    """Return about how many values a JSON text has, 0 for a short one. Raises RemoteProtocolError."""
    if len(text) < _SHORT_CHARACTERS:
        return 0
    containers = text.count("[") + text.count("{")
    if containers > MAX_CONTAINERS:
        raise RemoteProtocolError(f"a message may have at most {MAX_CONTAINERS} lists and objects")
    return text.count(",") + containers


def check_few_values(text: str) -> None:
    """Raise RemoteProtocolError for a text that takes a long time to parse."""
    if count_values(text) > MANY_VALUES:
        raise RemoteProtocolError(f"a JSON message may have at most {MANY_VALUES} values")


def parse_json(text: str) -> Any:
    """Return the value of a JSON text. Raises ValueError, RecursionError."""
    return json.loads(text) if len(text) < _MANY_CHARACTERS else _CHECKING_DECODER.decode(text)


def parse_in_steps(text: str) -> Any:
    """Return the value of a JSON text without blocking other threads. Raises ValueError, RecursionError."""
    decoder: Any = JSONDecoder(parse_int=_integer)
    decoder.parse_array = _parse_array
    decoder.scan_once = py_make_scanner(decoder)
    return decoder.decode(text)


def _parse_array(
    text_and_start: tuple[str, int], scan_once: Callable[[str, int], tuple[Any, int]]
) -> tuple[list[Any], int]:
    text, end = text_and_start
    numbers: list[Any] = []
    while found := _NUMBERS.match(text, end):
        numbers += json.loads(f"[{found[0][:-1]}]")
        end = found.end()
    rest, after = JSONArray((text, end), scan_once)
    if numbers and not rest:
        raise JSONDecodeError("Illegal trailing comma before end of array", text, end - 1)
    return numbers + rest, after


def show(value: object) -> str:
    """Return a client's value for an error: its JSON, shortened to one line."""
    # Millions of values would take a second, in which no other client is served.
    text = json.dumps(_beginning(value, _SHOWN_DEPTH), ensure_ascii=False)
    return escape_line(text.replace(f'"{_REST}"', _REST), _MAX_SHOWN)


def _beginning(value: object, depth: int) -> object:
    if isinstance(value, bytes):
        return value[: _MAX_SHOWN + 1].decode("utf-8", "replace")
    if isinstance(value, str):
        return value[: _MAX_SHOWN + 1]
    if isinstance(value, list):
        # A value takes at least two characters.
        return [_beginning(each, depth - 1) for each in value[:_MAX_SHOWN]] if depth else [_REST]
    if isinstance(value, dict):
        if not depth:
            return {_REST: _REST}
        items = islice(value.items(), _MAX_SHOWN)
        return {name[:_MAX_SHOWN]: _beginning(each, depth - 1) for name, each in items}
    return value
