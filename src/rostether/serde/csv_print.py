"""Messages as rows of numbers, as `rostopic echo -p` prints them.

As in ROS Noetic, uint8[] and char[] of a message are omitted, and strings are not quoted.
Lists of lists, which two slices in a field path select, are printed, while rostopic omits them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rostether.msgdef.spec import FieldType
from rostether.rostime import Duration, Time
from rostether.serde.plain_form import clean_text
from rostether.serde.values import Message
from rostether.serde.yaml_print import EchoStyle

_HEADER_TYPE = FieldType("std_msgs/Header")


def csv_header(value: Any, style: EchoStyle | None = None) -> str:
    """Return the line of column names for a message, or for what a field path selected."""
    return "%time," + ",".join(_columns(value, "field", style or EchoStyle()))


def csv_row(value: Any, now: Time, style: EchoStyle | None = None, *, uses_stamp: bool = True) -> str:
    """Return one row. Its first column, in ns, is the stamp of the message's header, or else `now`."""
    style = style or EchoStyle()
    offset_ns = style.time_offset.to_ns() if style.time_offset is not None else 0
    stamp = value.header.stamp if uses_stamp and isinstance(value, Message) and has_header(value) else now
    return f"{stamp.to_ns() - offset_ns}," + ",".join(_cells(value, style))


def _columns(value: Any, name: str, style: EchoStyle) -> Iterator[str]:
    if isinstance(value, Message):
        for field, field_value in _shown_fields(value, style):
            yield from _columns(field_value, f"{name}.{field}", style)
    elif isinstance(value, list):
        for index, each in enumerate(value):
            yield from _columns(each, f"{name}{index}", style)
    elif not isinstance(value, bytes):
        yield name


def _cells(value: Any, style: EchoStyle) -> Iterator[str]:
    if isinstance(value, Message):
        for _, field_value in _shown_fields(value, style):
            yield from _cells(field_value, style)
    elif isinstance(value, list):
        for each in value:
            yield from _cells(each, style if isinstance(each, Message) else EchoStyle())
    elif isinstance(value, bool):
        yield "1" if value else "0"
    elif isinstance(value, Time | Duration):
        offset = style.time_offset if isinstance(value, Time) else None
        yield str(value.to_ns() - (offset.to_ns() if offset is not None else 0))
    elif isinstance(value, str):
        yield clean_text(value)
    elif not isinstance(value, bytes):
        yield str(value)


def _shown_fields(message: Message, style: EchoStyle) -> Iterator[tuple[str, Any]]:
    for name, field_type in message._fields:
        hidden = (style.no_arrays and field_type.is_array) or (
            style.no_strings and field_type.base == "string"
        )
        if not hidden:
            yield name, getattr(message, name)


def has_header(message: Message) -> bool:
    """Return whether the first std_msgs/Header field is named `header`, as `has_header` in genmsg."""
    names = [name for name, field_type in message._fields if field_type == _HEADER_TYPE]
    return names[:1] == ["header"]
