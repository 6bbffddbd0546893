"""Messages of ROS 2 as text: YAML and CSV as `ros2 topic echo` prints them, and as rclpy prints them.

Texts and arrays longer than `truncate_length` are cut, with `...` for the rest; None cuts nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from msgspec import Struct

from rostether.msgdef.ros2.primitives import PRIMITIVE_TYPES
from rostether.msgdef.ros2.spec import Ros2Message, Ros2Type
from rostether.serde.plain_form import clean_text
from rostether.serde.values import Message

DEFAULT_TRUNCATE_LENGTH = 128
_CUT = "..."
_ESCAPED = "\\U000"
# The line length for YAML, so that it folds no line.
_WIDE = (1 << 31) - 1

# The names of primitives in IDL.
_IDL_NAMES = {
    "bool": "boolean",
    "byte": "octet",
    "char": "uint8",
    "float32": "float",
    "float64": "double",
}


class TextStyle(Struct, frozen=True):
    """The options of `ros2 topic echo` for the text of a message."""

    truncate_length: int | None = DEFAULT_TRUNCATE_LENGTH
    no_arrays: bool = False
    no_strings: bool = False
    flow_style: bool = False


class MessageText:
    """Prints messages; `lookup` returns the ROS 2 definition of a message by its full name."""

    def __init__(self, lookup: Callable[[str], Ros2Message], style: TextStyle) -> None:
        self._lookup = lookup
        self._style = style

    def yaml(self, message: Message, definition: Ros2Message) -> str:
        """Return a message's YAML, which ends with a line break."""
        import yaml

        def dump(dumper: Any) -> str:
            text: str = yaml.dump(
                fields,
                Dumper=dumper,
                allow_unicode=True,
                sort_keys=False,
                width=_WIDE,
                default_flow_style=self._style.flow_style,
            )
            return text

        fields = self._fields(message, definition)
        text = dump(getattr(yaml, "CSafeDumper", yaml.SafeDumper))
        # libyaml is faster, but it escapes emoji and all other characters with four bytes in UTF-8.
        return dump(yaml.SafeDumper) if _ESCAPED in text else text

    def csv(self, message: Message, definition: Ros2Message) -> str:
        """Return all fields of a message and of its nested messages, with commas between."""
        return ",".join(self._cells(message, definition))

    def python(self, message: Message, definition: Ros2Message) -> str:
        """Return a message as rclpy prints it: `std_msgs.msg.String(data='hello')`."""
        fields = ", ".join(
            f"{field.name}={self._python_value(getattr(message, field.name), field.type)}"
            for field in definition.fields
        )
        return f"{definition.full_name.replace('/', '.')}({fields})"

    def python_value(self, value: Any, field_type: Ros2Type) -> str:
        """Return the value of a field as `print` shows it: a string without quotes."""
        return clean_text(value) if isinstance(value, str) else self._python_value(value, field_type)

    def _fields(self, message: Message, definition: Ros2Message) -> dict[str, Any]:
        return {
            field.name: self._field(getattr(message, field.name), field.type) for field in definition.fields
        }

    def _field(self, value: Any, field_type: Ros2Type) -> Any:
        if not field_type.is_array:
            return self._item(value, field_type)
        if self._style.no_arrays:
            return array_summary(value, field_type)
        limit = self._style.truncate_length
        if limit is not None and len(value) > limit:
            return [*(self._item(each, field_type) for each in value[:limit]), _CUT]
        return [self._item(each, field_type) for each in value]

    def _item(self, value: Any, field_type: Ros2Type) -> Any:
        if isinstance(value, str):
            return self._text(clean_text(value))
        if field_type.base == "byte":
            # As in rclpy: a text of one character.
            return chr(value)
        if isinstance(value, Message):
            return self._fields(value, self._lookup(field_type.base))
        return value

    def _text(self, text: str) -> str:
        if self._style.no_strings:
            return f"<string length: <{len(text)}>>"
        limit = self._style.truncate_length
        return text if limit is None or len(text) <= limit else text[:limit] + _CUT

    def _cells(self, message: Message, definition: Ros2Message) -> Iterator[str]:
        for field in definition.fields:
            value, field_type = getattr(message, field.name), field.type
            if not field_type.is_array:
                yield self._cell(value, field_type)
            elif self._style.no_arrays:
                yield array_summary(value, field_type)
            else:
                yield ",".join(self._array_cells(value, field_type))

    def _array_cells(self, values: Any, field_type: Ros2Type) -> Iterator[str]:
        for index, value in enumerate(values):
            if self._style.truncate_length is not None and index >= self._style.truncate_length:
                yield _CUT
                return
            yield self._cell(value, field_type)

    def _cell(self, value: Any, field_type: Ros2Type) -> str:
        if isinstance(value, Message):
            return self.csv(value, self._lookup(field_type.base))
        if isinstance(value, str):
            return self._text(clean_text(value))
        return repr(bytes([value])) if field_type.base == "byte" else str(value)

    def _python_value(self, value: Any, field_type: Ros2Type) -> str:
        if isinstance(value, list | bytes):
            return f"[{', '.join(self._python_value(each, field_type) for each in value)}]"
        if isinstance(value, Message):
            return self.python(value, self._lookup(field_type.base))
        if isinstance(value, str):
            return repr(clean_text(value))
        return repr(bytes([value]) if field_type.base == "byte" else value)


def array_summary(values: Any, field_type: Ros2Type) -> str:
    """Return the text that replaces an omitted array."""
    base = field_type.base
    name = _IDL_NAMES.get(base, base) if base in PRIMITIVE_TYPES else base
    if field_type.length is not None:
        return f"<array type: {name}[{field_type.length}]>"
    bound = f"[{field_type.bound}]" if field_type.bound is not None else ""
    return f"<sequence type: {name}{bound}, length: {len(values)}>"
