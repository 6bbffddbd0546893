"""Messages as users type them for `ros2 topic pub`: YAML, with the default values of ROS 2 definitions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rostether.msgdef.ros2.primitives import PRIMITIVE_TYPES
from rostether.msgdef.ros2.spec import Ros2Field, Ros2Message, Ros2Type

if TYPE_CHECKING:
    from rostether.rostime import Time
    from rostether.serde.codec import Codec
    from rostether.serde.values import Message

_TIME = "builtin_interfaces/msg/Time"
_HEADER = "std_msgs/msg/Header"


class ValueForm:
    """Fills messages; `lookup` returns the ROS 2 definition of a message by its full name."""

    def __init__(self, lookup: Callable[[str], Ros2Message], now: Callable[[], Time]) -> None:
        self._lookup = lookup
        self._now = now

    def fill(self, codec: Codec, definition: Ros2Message, values: Sequence[Any]) -> Message:
        """Return the message of loaded arguments: one mapping, or the value of each field in order.

        The text `now` becomes the current time, and `auto` a header with this time. Raises SerializationError
        naming the field.
        """
        from rostether.serde.yaml_form import fill_message

        names = [field.name for field in definition.fields]
        content: Any = {}
        if len(values) == 1 and isinstance(values[0], Mapping):
            content = values[0]
        elif values and values != [None]:
            content = dict(zip(names, values, strict=False)) if len(values) == len(names) else list(values)
        if isinstance(content, list):
            return fill_message(codec, content, now=self._now)
        return fill_message(codec, [self._with_defaults(content, definition)], now=self._now)

    def _with_defaults(self, content: Any, definition: Ros2Message) -> Any:
        if content is None or content == "":
            content = {}
        if definition.full_name == _TIME and content == "now":
            stamp = self._now()
            return {"sec": stamp.secs, "nanosec": stamp.nsecs}
        if definition.full_name == _HEADER and content == "auto":
            content = {"stamp": "now"}
        if not isinstance(content, Mapping):
            # A list of all fields; the codec reports anything else.
            return content
        filled = dict(content)
        for field in definition.fields:
            if field.name not in filled:
                self._add_default(filled, field)
            elif field.type.base not in PRIMITIVE_TYPES:
                filled[field.name] = self._given(filled[field.name], field)
        return filled

    def _given(self, value: Any, field: Ros2Field) -> Any:
        definition = self._lookup(field.type.base)
        if field.type.is_array:
            if not isinstance(value, list):
                return value
            return [self._with_defaults(each, definition) for each in value]
        return self._with_defaults(value, definition)

    def _add_default(self, filled: dict[str, Any], field: Ros2Field) -> None:
        if field.default is not None:
            default = field.default
            filled[field.name] = list(default) if isinstance(default, tuple) else default
        elif field.type.base not in PRIMITIVE_TYPES:
            if field.type.length is not None:
                filled[field.name] = [self._given({}, _element(field)) for _ in range(field.type.length)]
            elif not field.type.is_array:
                filled[field.name] = self._given({}, field)


def _element(field: Ros2Field) -> Ros2Field:
    return Ros2Field(Ros2Type(field.type.base), field.name)
