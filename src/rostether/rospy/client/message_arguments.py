"""genpy.message's functions for arguments: they fill messages from the values that users type."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rostether.msgdef.primitives import CONSTANT_TYPES
from rostether.rospy.client.message import Message, MessageException
from rostether.rospy.client.message_types import get_message_class
from rostether.rospy.client.stamps import TVal
from rostether.rostime import NS_PER_S


def fill_message_args(msg: Any, msg_args: Any, keys: Mapping[str, Any] | None = None) -> None:
    """Fill a message with a list of all its fields, with a dict, or with a list of one dict.

    `keys` are the values of words for times and headers, such as `now`. Raises MessageException, ValueError.
    """
    arguments = [] if msg_args is None else msg_args
    if isinstance(arguments, list) and len(arguments) == 1 and isinstance(arguments[0], dict):
        arguments = arguments[0]
    _fill(msg, arguments, keys or {}, "")


def get_printable_message_args(msg: Any, buff: Any = None, prefix: str = "") -> str:
    """Return the names of a message's fields, including the fields of nested messages."""
    names = []
    for name in msg.__slots__:
        value = getattr(msg, name)
        if isinstance(value, Message):
            names.append(get_printable_message_args(value, prefix=f"{prefix}{name}."))
        else:
            names.append(prefix + name)
    text = " ".join(filter(None, names))
    if buff is not None:
        buff.write(f"{text} ")
    return text


def _fill(msg: Any, arguments: Any, keys: Mapping[str, Any], prefix: str) -> None:
    if not isinstance(msg, Message | TVal):
        raise ValueError(f"msg must be a Message instance: {msg}")  # noqa: TRY004 - as genpy raises it
    names = ["secs", "nsecs"] if isinstance(msg, TVal) else list(msg.__slots__)
    if isinstance(arguments, dict):
        values = {name: "" if value is None else value for name, value in arguments.items()}
    elif isinstance(arguments, list):
        if len(arguments) != len(names):
            wrong = "Too many" if len(arguments) > len(names) else "Not enough"
            raise MessageException(f"{wrong} arguments:\n * Given: {arguments}\n * Expected: {names}")
        values = dict(zip(names, arguments, strict=True))
    else:
        raise ValueError(f"invalid msg_args type: {arguments}")  # noqa: TRY004
    for name, value in values.items():
        if name not in names:
            raise MessageException(f"No field name [{prefix}{name}]")
        _fill_field(msg, name, value, keys, prefix)


def _fill_field(msg: Any, name: str, value: Any, keys: Mapping[str, Any], prefix: str) -> None:
    current = getattr(msg, name)
    if isinstance(current, Message | TVal):
        if isinstance(value, str):
            if value not in keys:
                raise MessageException(f"No key named [{value}]")
            setattr(msg, name, keys[value])
        else:
            setattr(msg, name, _filled(current, value, keys, f"{prefix}{name}."))
    elif isinstance(current, list):
        setattr(msg, name, _elements(msg, name, value, keys, prefix))
    else:
        setattr(msg, name, value)


def _elements(msg: Any, name: str, value: Any, keys: Mapping[str, Any], prefix: str) -> list[Any]:
    if not isinstance(value, list | tuple):
        raise MessageException(
            f"Field [{prefix}{name}] must be a list or tuple instead of: {type(value).__name__}"
        )
    element, _, length = msg._slot_types[list(msg.__slots__).index(name)].removesuffix("]").partition("[")
    if length and len(value) != int(length):
        raise MessageException(
            f"Field [{prefix}{name}] has incorrect number of elements: {len(value)} != {length}"
        )
    if element in CONSTANT_TYPES:
        return list(value)
    element_class = get_message_class(element)
    if element_class is None:
        raise MessageException(
            f"Cannot instantiate messages for field [{prefix}{name}] : cannot load class {element}"
        )
    return [_filled(element_class(), each, keys, prefix) for each in value]


def _filled(current: Any, value: Any, keys: Mapping[str, Any], prefix: str) -> Any:
    if isinstance(current, TVal) and isinstance(value, int) and not isinstance(value, bool):
        return type(current)(*divmod(value, NS_PER_S))
    _fill(current, value, keys, prefix)
    return current
