"""Messages as values for JSON, for `--json`.

uint8[] and char[] become lists of integers, times and durations `{"secs": ..., "nsecs": ...}`. JSON has no
NaN or infinity: they become the strings "NaN", "Infinity" and "-Infinity" (as in protobuf's JSON), which
`yaml_form` reads back. Bytes that are not UTF-8 become U+FFFD.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Callable
from typing import Any

from rostether.rostime import Duration, Time
from rostether.serde.values import Message


def to_plain(message: Message) -> dict[str, Any]:
    """Return a message as dicts, lists, strings, numbers and bools, fields in the order of the definition."""
    return plain_value(message)  # type: ignore[no-any-return]


def plain_value(
    value: Any,
    of_bytes: Callable[[bytes], Any] = list,
    of_stamp: Callable[[Time | Duration], Any] = lambda stamp: {"secs": stamp.secs, "nsecs": stamp.nsecs},
) -> Any:
    """Return a value as `to_plain` does, with bytes and times as the functions return them."""
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    if isinstance(value, str):
        return clean_text(value)
    if isinstance(value, list):
        return [plain_value(each, of_bytes, of_stamp) for each in value]
    if isinstance(value, dict):
        return {clean_text(name): plain_value(each, of_bytes, of_stamp) for name, each in value.items()}
    if isinstance(value, bytes):
        return of_bytes(value)
    if isinstance(value, Message):
        return {name: plain_value(getattr(value, name), of_bytes, of_stamp) for name, _ in value._fields}
    if isinstance(value, Time | Duration):
        return of_stamp(value)
    return value


def base64_text(value: bytes) -> str:
    """Return bytes as base64 text, because a list of numbers would not show that they are bytes."""
    return base64.b64encode(value).decode()


def clean_text(text: str) -> str:
    """Return a decoded string with its bytes that are not UTF-8 replaced by U+FFFD."""
    if text.isascii():
        return text
    return text.encode("utf-8", "surrogateescape").decode("utf-8", "replace")
