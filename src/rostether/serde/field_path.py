"""Paths to fields of messages, as after the topic in `rostopic echo /scan/ranges[3]`.

pose/position/x     ranges[3]     ranges[-1]     ranges[::10]     transforms[:]/header/frame_id
"""

from __future__ import annotations

from typing import Any

from rostether.errors import ConfigError, SerializationError
from rostether.mechanisms.text import counted, did_you_mean
from rostether.msgdef.spec import FieldType
from rostether.serde.codec import Codec
from rostether.serde.type_tree import Array, Member, Struct

# start:stop:step
_MAX_SLICE_PARTS = 3


class FieldPath:
    """A path that exists in a message type; `type` is the type of its last field."""

    def __init__(self, codec: Codec, text: str) -> None:
        """Read a path; repeated slashes do not matter. Raises ConfigError if the type has no such field."""
        parts = [part for part in text.split("/") if part] or [""]
        self.text = "/".join(parts)
        self._steps: list[tuple[str, int | slice | None]] = []
        tree: Struct | None = codec.tree
        within = codec.type_name
        for number, part in enumerate(parts, 1):
            name, bracket, rest = part.partition("[")
            if tree is None:
                raise ConfigError(
                    f"{within} has no fields, so {self.text!r} cannot continue with {part!r}; end it there"
                )
            member = _member(tree, name)
            index = read_index(part, rest) if bracket else None
            self.type: FieldType = member.type
            self._steps.append((name, index))
            tree = _inside(member, index, is_last=number == len(parts))
            within = f"field {part!r}"

    def read(self, message: Any) -> Any:
        """Return the selected value, bytes as a list. Raises SerializationError for a missing element."""
        return self._read(message, 0)

    def _read(self, value: Any, start: int) -> Any:
        for number, (name, index) in enumerate(self._steps[start:], start + 1):
            value = getattr(value, name)
            if isinstance(value, bytes):
                value = list(value)
            if isinstance(index, slice):
                return [self._read(each, number) for each in value[index]]
            if index is not None:
                try:
                    value = value[index]
                except IndexError:
                    raise SerializationError(
                        f"{self.text!r} selects element {index} of {name!r}, which has "
                        f"{counted(len(value), 'element')}; choose another index"
                    ) from None
        return value


def _member(tree: Struct, name: str) -> Member:
    for member in tree.members:
        if member.name == name:
            return member
    known = ", ".join(member.name for member in tree.members) or "no fields"
    hint = did_you_mean(name, [member.name for member in tree.members])
    raise ConfigError(f"{tree.name} has no field {name!r}; it has {known}{hint and f'; {hint}'}")


def _inside(member: Member, index: int | slice | None, *, is_last: bool) -> Struct | None:
    """Return the struct that has the next part of the path as a field, if there is one."""
    node = member.node
    if not isinstance(node, Array):
        if index is not None:
            raise ConfigError(f"field {member.name!r} is a {member.type}, not an array; omit the [ ]")
        return node if isinstance(node, Struct) else None
    if index is None and not is_last:
        raise ConfigError(f"field {member.name!r} is an array; select elements, e.g. {member.name}[0]")
    return node.element if isinstance(node.element, Struct) else None


def read_index(part: str, rest: str) -> int | slice:
    """Read `3]` or `1:10:2]`, the rest of a part of a path after its `[`. Raises ConfigError."""
    name = part.partition("[")[0]
    texts = rest.removesuffix("]").split(":")
    try:
        if not rest.endswith("]") or len(texts) > _MAX_SLICE_PARTS:
            raise ValueError(part)
        if len(texts) == 1:
            return int(texts[0])
        chosen = slice(*(int(text) if text else None for text in texts))
        if chosen.step == 0:
            raise ValueError(part)
    except ValueError:
        raise ConfigError(f"{part!r} selects no elements; write {name}[3] or {name}[2:10:2]") from None
    return chosen
