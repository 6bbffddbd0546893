"""Messages as text, byte for byte as `rostopic echo` of ROS Noetic prints them.

That includes its peculiarities: a blank after the name of a nested message, `nsecs` padded to nine columns,
and `--nostr` not applied to strings in arrays of messages. Two things differ because genpy fails there:
char[] prints as a list of numbers, and so does a uint8[] selected by a field path.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, Final

from msgspec import Struct

from rostether.msgdef.spec import FieldType
from rostether.rostime import NS_PER_S, Duration, Time
from rostether.serde.plain_form import clean_text
from rostether.serde.values import Message

# Strings that the YAML emitter would only put in quotes: no escapes, and short enough not to be folded.
_PLAIN_TEXT: Final = re.compile(r"[ !#-\[\]-~]{1,70}")


class EchoStyle(Struct, frozen=True):
    """The parts that `rostopic echo` can omit or print differently.

    `time_offset` is subtracted from times (--offset), `number_width` is the columns of a number (-w).
    """

    no_arrays: bool = False
    no_strings: bool = False
    time_offset: Time | None = None
    number_width: int | None = None


def format_message(message: Message, style: EchoStyle | None = None) -> str:
    """Return a message as `rostopic echo` prints it, without the `---` and without a newline at the end."""
    return _Printer(style or EchoStyle()).message(message, "", elide=True)


def format_value(value: Any, field_type: FieldType, style: EchoStyle | None = None) -> str:
    """Return the value of a field path as `rostopic echo` prints it; `field_type` is the last field's."""
    printer = _Printer(style or EchoStyle())
    if isinstance(value, Message):
        return printer.message(value, "", elide=True)
    return printer.value(printer.elided(value, field_type), "")


class _Printer:
    """Prints values in one style; `indent` precedes each line of a nested value."""

    def __init__(self, style: EchoStyle) -> None:
        self._style = style

    def message(self, message: Message, indent: str, *, elide: bool = False) -> str:
        """Return the fields below each other; values are elided only outside of arrays."""
        lines = []
        for name, field_type in message._fields:
            value = getattr(message, name)
            if not indent and isinstance(value, Time | Duration):
                # genpy carries surplus nanoseconds over, but only in fields of the message itself.
                value = type(value).from_ns(value.to_ns())
            if elide and isinstance(value, Message):
                text = self.message(value, f"  {indent}", elide=True)
            else:
                text = self.value(self.elided(value, field_type) if elide else value, f"  {indent}")
            lines.append(f"{indent}{name}: {text}")
        text = "\n".join(lines)
        return f"\n{text}" if indent else text

    def value(self, value: Any, indent: str) -> str:
        if isinstance(value, Message):
            return self.message(value, indent)
        if isinstance(value, str):
            return quoted_text(clean_text(value))
        if isinstance(value, Time | Duration):
            return self._stamp(value, indent)
        if isinstance(value, list | bytes):
            return self._list(value, indent)
        return self._number(value)

    def elided(self, value: Any, field_type: FieldType) -> Any:
        """Return the value, or the remark that --noarr or --nostr puts in its place."""
        is_list = isinstance(value, list | bytes)
        if self._style.no_arrays and field_type.is_array and is_list:
            # rostopic strips the brackets of `int8[]`, but not those of `int8[3]`.
            return f"<array type: {str(field_type).rstrip('[]')}, length: {len(value)}>"
        if self._style.no_strings and field_type.base == "string":
            if isinstance(value, str):
                return f"<string length: {len(clean_text(value))}>"
            if is_list and field_type.length is None:
                return f"<array type: string, length: {len(value)}>"
        return value

    def _list(self, values: list[Any] | bytes, indent: str) -> str:
        if not values:
            return "[]"
        first = values[0]
        if isinstance(first, str):
            return string_list([clean_text(str(each)) for each in values], indent)
        if isinstance(first, bool | int | float) and not isinstance(first, Time | Duration):
            if self._style.number_width is None or isinstance(first, bool):
                return str(list(values))
            return f"[{''.join(f'{self._number(each)}, ' for each in values).rstrip(', ')}]"
        return "\n" + "\n".join(f"{indent}- {self.value(each, f'  {indent}')}" for each in values)

    def _number(self, value: Any) -> str:
        width = self._style.number_width
        if width is None or isinstance(value, bool):
            return str(value)
        if isinstance(value, float):
            text = f"{value:.{width}f}"
            return text[: max(text.find("."), width)]
        return f"{value:{width}d}"

    def _stamp(self, stamp: Time | Duration, indent: str) -> str:
        secs, nsecs = stamp
        if self._style.time_offset is not None and isinstance(stamp, Time):
            secs, nsecs = divmod(stamp.to_ns() - self._style.time_offset.to_ns(), NS_PER_S)
        width = self._style.number_width
        if width is None:
            return f"\n{indent}secs: {secs}\n{indent}nsecs: {nsecs:9d}"
        return f"\n{indent}secs: {secs:{width}d}\n{indent}nsecs: {nsecs:{width}d}"


def quoted_text(text: str) -> str:
    """Return a string in quotes."""
    if not text:
        return "''"
    if _PLAIN_TEXT.fullmatch(text):
        return f'"{text}"'
    import yaml

    quoted: str = yaml.dump(text, default_style='"')
    return quoted.rstrip("\n")


def string_list(texts: Sequence[str], indent: str) -> str:
    """Return a newline, and the strings as a YAML list with one line for each."""
    import yaml

    lines: str = yaml.dump(list(texts))
    return "\n" + "\n".join(indent + line for line in lines.rstrip("\n").splitlines())
