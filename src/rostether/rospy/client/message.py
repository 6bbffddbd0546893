"""Messages like those of genpy: positional or keyword fields, `serialize`, `deserialize`, printed as YAML.

Their classes are derived from those of serde, so that compiled codecs read and write them.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

from rostether.errors import SerializationError as _Misfit
from rostether.rospy.client.exceptions import ROSException
from rostether.rospy.client.stamps import TVal
from rostether.serde.codec import Codec
from rostether.serde.type_tree import Array, Number, Struct
from rostether.serde.values import Message as _SerdeMessage
from rostether.serde.yaml_print import quoted_text, string_list


class MessageException(Exception):
    """The base of genpy's errors."""


class SerializationError(MessageException):
    """A value does not fit its field."""


class DeserializationError(MessageException):
    """Bytes do not fit the type."""


class Message(_SerdeMessage):
    """Base of all message classes: each has `_type`, `_md5sum`, `_full_text`, `_slot_types`, `_has_header`.

    `_connection_header` is set on messages that came from the graph. Raises TypeError or AttributeError for
    arguments that are not the fields.
    """

    __slots__ = ("_connection_header",)

    _md5sum: ClassVar[str] = ""
    _full_text: ClassVar[str] = ""
    _has_header: ClassVar[bool] = False
    _slot_types: ClassVar[list[str]] = []
    _codec: ClassVar[Codec]

    def __init__(self, *args: Any, **kwds: Any) -> None:
        names = self._field_names()
        if args and kwds:
            raise TypeError("Message constructor may only use args OR keywords, not both")
        if args and len(args) != len(names):
            raise TypeError(f"Invalid number of arguments, args should be {list(names)} args are {args}")
        values = dict(zip(names, args, strict=True)) if args else kwds
        for name in values:
            if name not in names:
                raise AttributeError(f"{name} is not an attribute of {type(self).__name__}")
        for name, zero in self._zeros:
            value = values.get(name)
            if value is None:
                value = zero() if callable(zero) else zero
            setattr(self, name, value)

    def serialize(self, buff: Any) -> None:
        """Write the wire form to a binary buffer. Raises SerializationError, which names the field."""
        buff.write(self._to_bytes())

    def deserialize(self, str: bytes) -> Message:
        """Read the fields from the wire form. Raises DeserializationError."""
        try:
            found = self._codec.decode(bytes(str))
        except _Misfit as error:
            raise DeserializationError(f"{error}") from None
        for name in self._field_names():
            setattr(self, name, getattr(found, name))
        return self

    def serialize_numpy(self, buff: Any, numpy: object) -> None:
        """Write the wire form; fields may be numpy arrays."""
        self.serialize(buff)

    def deserialize_numpy(self, str: bytes, numpy: Any) -> Message:
        """Read the fields from the wire form, arrays of numbers as numpy arrays."""
        self.deserialize(str)
        _arrays_to_numpy(self, self._codec.tree, numpy)
        return self

    def _to_bytes(self) -> bytes:
        try:
            return self._codec.encode(self)
        except _Misfit as error:
            raise SerializationError(f"{error}") from None

    def _check_types(self, exc: Exception | None = None) -> None:
        """Raise SerializationError if a field has a wrong value, or if `exc` is given (with its text)."""
        self._to_bytes()
        if exc is not None:
            raise SerializationError(f"{exc}")

    def _get_types(self) -> list[str]:
        return self._slot_types

    @classmethod
    def _field_names(cls) -> tuple[str, ...]:
        return tuple(name for name, _ in cls._zeros)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and all(
            _as_tuple(getattr(self, name)) == _as_tuple(getattr(other, name)) for name in self._field_names()
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return strify_message(self)

    __str__ = __repr__

    def __getstate__(self) -> list[Any]:
        return [getattr(self, name) for name in self._field_names()]

    def __setstate__(self, state: list[Any]) -> None:
        for name, value in zip(self._field_names(), state, strict=True):
            setattr(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (), self.__getstate__()


class AnyMsg(Message):
    """A message of any type, with its bytes in `_buff`; programs can publish it again, but not read it."""

    __slots__ = ("_buff",)

    _type = "*"
    _md5sum = "*"

    def __init__(self, *args: Any) -> None:
        if args:
            raise ROSException("AnyMsg does not accept arguments")
        self._buff: bytes | None = None

    def deserialize(self, str: bytes) -> AnyMsg:
        """Keep the bytes."""
        self._buff = bytes(str)
        return self

    def _to_bytes(self) -> bytes:
        if self._buff is None:
            raise ROSException("AnyMsg is not initialized")
        return self._buff

    def __eq__(self, other: object) -> bool:
        return isinstance(other, AnyMsg) and self._buff == other._buff

    __hash__ = None


def message_bytes(message: Message) -> bytes:
    """Return the wire form, by `serialize` if the class overrides it. Raises SerializationError."""
    if type(message).serialize is Message.serialize:
        return message._to_bytes()
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def serialize_message(b: Any, seq: int, msg: Message) -> None:
    """Write a message to a binary buffer as TCPROS sends it: its length, then its wire form with `seq`."""
    if msg._has_header:
        msg.header.seq = seq
    payload = message_bytes(msg)
    b.write(len(payload).to_bytes(4, "little") + payload)


def read_message(message_class: type[Message], payload: bytes) -> Message:
    """Return the message in a payload, by `deserialize` if the class overrides it.

    Raises DeserializationError.
    """
    if message_class.deserialize is not Message.deserialize:
        return message_class().deserialize(payload)
    found: Any
    try:
        found = message_class._codec.decode(payload)
    except _Misfit as error:
        raise DeserializationError(f"{error}") from None
    return found  # type: ignore[no-any-return]


def strify_message(
    val: Any,
    indent: str = "",
    time_offset: Any = None,
    current_time: Any = None,
    field_filter: Callable[[Message], Iterator[str]] | None = None,
) -> str:
    """Return a value as YAML, as `print(message)` shows it under rospy."""
    if isinstance(val, Message):
        shown = list(val._field_names()) if field_filter is None else list(field_filter(val))
        lines = []
        for name, kind in zip(val._field_names(), val._slot_types, strict=True):
            if name in shown:
                value = getattr(val, name)
                if isinstance(value, bytes) and "uint8[" in kind:
                    value = list(value)
                text = strify_message(value, f"  {indent}", time_offset, current_time, field_filter)
                lines.append(f"{indent}{name}: {text}")
        text = "\n".join(lines)
        return f"\n{text}" if indent else text
    if isinstance(val, TVal):
        shown_time = val - time_offset if time_offset is not None and hasattr(val, "to_time") else val
        return f"\n{indent}secs: {shown_time.secs}\n{indent}nsecs: {shown_time.nsecs:9d}"
    if isinstance(val, str):
        return quoted_text(val)
    if isinstance(val, list | tuple):
        return _list_text(val, indent, time_offset, current_time, field_filter)
    return str(val)


def _list_text(values: Any, indent: str, *settings: Any) -> str:
    if not values:
        return "[]"
    if isinstance(values[0], str):
        return string_list(values, indent)
    if isinstance(values[0], int | float):
        return str(list(values))
    return "\n" + "\n".join(f"{indent}- {strify_message(each, f'{indent}  ', *settings)}" for each in values)


def _as_tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


_NUMPY_NAMES = {"bool": "bool", "byte": "int8", "char": "uint8"}


def _arrays_to_numpy(message: Any, tree: Struct, numpy: Any) -> None:
    for member in tree.members:
        value = getattr(message, member.name)
        node = member.node
        if isinstance(node, Struct):
            _arrays_to_numpy(value, node, numpy)
        elif isinstance(node, Array) and isinstance(node.element, Struct):
            for each in value:
                _arrays_to_numpy(each, node.element, numpy)
        elif isinstance(node, Array) and isinstance(node.element, Number):
            dtype = _NUMPY_NAMES.get(node.element.name, node.element.name)
            array = numpy.frombuffer(value, dtype) if isinstance(value, bytes) else numpy.array(value, dtype)
            setattr(message, member.name, array)
