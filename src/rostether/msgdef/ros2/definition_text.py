"""A ROS 2 message as the text of a .msg file, and as a full text (see `msgdef.full_text`), as in bags."""

from __future__ import annotations

import json
from typing import Protocol

from rostether.msgdef.full_text import SEPARATOR
from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.ros2.spec import ConstantValue, DefaultValue, Ros2Message, Ros2Type
from rostether.msgdef.ros2.to_ros1 import MessageSource, ros1_name


class TextSource(MessageSource, Protocol):
    """Finds messages and their texts, like `Ros2Definitions`."""

    def text(self, name: str) -> str:
        """Return a message's own text."""


def message_text(message: Ros2Message) -> str:
    """Return the text of a message that has no file: one line for each constant and field."""
    lines = [f"{each.type} {each.name}={_literal(each.value)}" for each in message.constants]
    for field in message.fields:
        default = "" if field.default is None else f" {_default(field.default)}"
        lines.append(f"{_type_text(field.type)} {field.name}{default}")
    return "".join(f"{line}\n" for line in lines)


def full_text(message: Ros2Message, source: TextSource) -> str:
    """Return the texts of a message and its nested messages. Raises UnknownTypeError, DefinitionError."""
    texts = [source.text(message.full_name)]
    texts += [
        f"{SEPARATOR}\nMSG: {ros1_name(below.full_name)}\n{source.text(below.full_name)}"
        for below in dependencies(message, source.message)
    ]
    return "\n".join(text.removesuffix("\n") for text in texts) + "\n"


def _type_text(field_type: Ros2Type) -> str:
    text = str(field_type)
    return text.replace(field_type.base, ros1_name(field_type.base), 1) if "/" in field_type.base else text


def _default(value: DefaultValue) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_literal, value))}]"
    return _literal(value)


def _literal(value: ConstantValue) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
