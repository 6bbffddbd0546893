"""Matches the fields of a ROS 1 definition with those of a ROS 2 one.

Fields are matched by name, or else by the name without capitals and underscores (`D` is `d` in ROS 2). A
field of only one side is dropped, or becomes zero or its default. If both sides have such fields, they are
probably one renamed field. Such types are refused, because a guess could lose values.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Final, Never

from rostether.errors import TypeMismatchError
from rostether.msgdef.ros2.primitives import STRING_TYPES
from rostether.msgdef.ros2.spec import ConstantValue, DefaultValue, Ros2Field, Ros2Message, Ros2Type
from rostether.serde import type_tree
from rostether.serde.cdr.conversion_tree import (
    DUMMY_NAME,
    Array,
    Node,
    Plain,
    Record,
    Side,
    Slot,
    Text,
    Translation,
)
from rostether.serde.cdr.offset import UNIT_BYTES, widen
from rostether.serde.cdr.renamed_types import RENAMED_FIELDS, RENAMED_VALUES
from rostether.serde.type_tree import MAX_DEPTH, MAX_FIXED_BYTES

Lookup = Callable[[str], Ros2Message]

# A bool is 0 or 1 in CDR, and other bytes are refused there; ROS 1 accepts any byte.
_BOOLS: Final = Translation(*[bytes([0]) + bytes([1]) * 255] * 2)

# The `struct` formats of ROS 2's numbers. `byte` is signed in ROS 1 and an octet in ROS 2.
_NUMBERS: Final[dict[str, str]] = {
    name: node.code for name, node in type_tree.SCALARS.items() if isinstance(node, type_tree.Number)
} | {"byte": "B"}
# (ROS 1, ROS 2): types with different names whose eight bits are the same.
_SAME_NUMBERS: Final = frozenset(
    {("byte", "int8"), ("byte", "uint8"), ("char", "uint8"), ("char", "byte")}
    | {("int8", "byte"), ("uint8", "byte"), ("uint8", "char")}
)

_STAMPS: Final = {"time": "builtin_interfaces/msg/Time", "duration": "builtin_interfaces/msg/Duration"}
_DUMMY: Final = Slot("", DUMMY_NAME, Plain(1, 1), ((1, b"\0"),))


def match_fields(ros1: type_tree.Struct, ros2: Ros2Message, lookup: Lookup) -> Record:
    """Return the two types as one tree; `lookup` returns nested ROS 2 messages by `package/msg/Name`.

    Raises TypeMismatchError if they do not fit, and the errors of `lookup`.
    """
    return _FieldMatcher(ros1.name, ros2.full_name, lookup).record(ros1, ros2, "")


class _FieldMatcher:
    def __init__(self, ros1_name: str, ros2_name: str, lookup: Lookup) -> None:
        self._names = f"{ros1_name} and {ros2_name}"
        self._lookup = lookup
        self._records: dict[tuple[str, str], Record] = {}

    def record(self, ros1: type_tree.Struct, ros2: Ros2Message, path: str) -> Record:
        """Pair two messages; `path` is their position, for errors."""
        key = (ros1.name, ros2.full_name)
        if key not in self._records:
            self._records[key] = self._paired(ros1, ros2, path)
        return self._records[key]

    def _paired(self, ros1: type_tree.Struct, ros2: Ros2Message, path: str) -> Record:
        if ros1.name in ("std_msgs/Time", "std_msgs/Duration") and ros2.full_name in _STAMPS.values():
            slot = Slot("data", "sec", Plain(8, 4))
            return Record(ros1.name, (slot,), (slot,))
        fields = {field.name: field for field in ros2.fields}
        by_spelling: dict[str, Ros2Field | None] = {}
        for field in ros2.fields:
            by_spelling[_spelling(field.name)] = None if _spelling(field.name) in by_spelling else field
        ros1_slots: list[Slot] = []
        paired: dict[str, Slot] = {}
        for member in ros1.members:
            name = RENAMED_FIELDS.get((ros1.name, member.name), member.name)
            other = fields.get(name) or by_spelling.get(_spelling(name))
            if other is None or other.name in paired:
                ros1_slots.append(Slot(member.name, "", _ros1_node(member.node)))
                continue
            node = self._node(member.node, other.type, f"{path}{member.name}")
            if (values := RENAMED_VALUES.get((ros1.name, member.name))) and ros2.full_name.endswith("/Log"):
                node = Plain(1, 1, values)
            slot = paired[other.name] = Slot(member.name, other.name, node)
            ros1_slots.append(slot)
        ros2_slots = [paired.get(field.name) or self._added(field) for field in ros2.fields]
        self._require_no_renaming(ros1.name, ros1_slots, ros2_slots, path)
        return Record(ros1.name, tuple(ros1_slots), tuple(ros2_slots) or (_DUMMY,))

    def _require_no_renaming(self, name: str, ros1: list[Slot], ros2: list[Slot], path: str) -> None:
        dropped = [slot.ros1_name for slot in ros1 if slot.side is Side.ROS1]
        added = [slot.ros2_name for slot in ros2 if slot.side is Side.ROS2]
        if name == "std_msgs/Header" and dropped == ["seq"]:
            dropped = []
        if dropped and added and name != "rosgraph_msgs/Log":
            self._refuse(
                f"only ROS 1 has {_listed(dropped)} and only ROS 2 has {_listed(added)}"
                + (f" in '{path.rstrip('.')}'" if path else "")
            )

    def _node(self, ros1: type_tree.Node, ros2: Ros2Type, path: str) -> Node:
        if not isinstance(ros1, type_tree.Array):
            if not ros2.is_array:
                return self._element(ros1, ros2, path)
        elif ros2.is_array and ros1.length == ros2.length:
            return Array(self._element(ros1.element, ros2, f"{path}[]"), ros1.length, ros2.bound)
        return self._refuse(f"'{path}' is {ros1.name} in ROS 1 and {ros2} in ROS 2")

    def _element(
        self,
        ros1: type_tree.Number | type_tree.Stamp | type_tree.Text | type_tree.Struct,
        ros2: Ros2Type,
        path: str,
    ) -> Plain | Text | Record:
        if isinstance(ros1, type_tree.Number):
            if ros1.name == ros2.base or (ros1.name, ros2.base) in _SAME_NUMBERS:
                return _number(ros1.name)
        elif isinstance(ros1, type_tree.Text):
            if ros2.base in STRING_TYPES:
                return Text(ros2.string_bound, ros2.base == "wstring")
        elif isinstance(ros1, type_tree.Stamp):
            if ros2.base == _STAMPS[ros1.name]:
                return Plain(8, 4)
        elif ros1.name == "std_msgs/Header" and ros2.base == _STAMPS["time"]:
            stamp = Slot("stamp", "stamp", Plain(8, 4))
            slots = (Slot("seq", "", Plain(4, 4)), stamp, Slot("frame_id", "", Text()))
            return Record(ros1.name, slots, (stamp,))
        elif "/" in ros2.base:
            return self.record(ros1, self._lookup(ros2.base), f"{path}.")
        return self._refuse(f"'{path}' is {ros1.name} in ROS 1 and {ros2} in ROS 2")

    def _added(self, field: Ros2Field) -> Slot:
        node = self._ros2_node(field.type, field.name, 1)
        return Slot("", field.name, node, tuple(_default(node, field.type, field.default)))

    def _ros2_node(self, ros2: Ros2Type, path: str, depth: int) -> Node:
        element: Plain | Text | Record
        if ros2.base in STRING_TYPES:
            element = Text(ros2.string_bound, ros2.base == "wstring")
        elif ros2.base in _NUMBERS:
            element = _number(ros2.base)
        elif "/" in ros2.base:
            if depth >= MAX_DEPTH:
                self._refuse(f"'{path}' nests types more than {MAX_DEPTH} levels deep in ROS 2")
            message = self._lookup(ros2.base)
            slots = []
            for field in message.fields:
                node = self._ros2_node(field.type, f"{path}.{field.name}", depth + 1)
                slots.append(Slot("", field.name, node, tuple(_default(node, field.type, field.default))))
            element = Record(message.full_name, (), tuple(slots) or (_DUMMY,))
        else:
            self._refuse(f"only ROS 2 has '{path}', and ROS 1 has no {ros2.base}")
        node = Array(element, ros2.length, ros2.bound) if ros2.is_array else element
        if node.min_bytes(Side.ROS2) > MAX_FIXED_BYTES:
            self._refuse(f"'{path}' needs more than {MAX_FIXED_BYTES} bytes in ROS 2")
        return node

    def _refuse(self, reason: str) -> Never:
        raise TypeMismatchError(
            f"{self._names} differ: {reason}; give both sides the same fields, or give the definition that"
            " the other side uses with --msg-path"
        )


def _number(name: str) -> Plain:
    size = struct.calcsize(f"<{_NUMBERS[name]}")
    return Plain(size, size, _BOOLS if name == "bool" else None)


def _ros1_node(node: type_tree.Node) -> Node:
    """Return a node that only ROS 1 has."""
    if isinstance(node, type_tree.Array):
        return Array(_ros1_element(node.element), node.length)
    return _ros1_element(node)


def _ros1_element(
    node: type_tree.Number | type_tree.Stamp | type_tree.Text | type_tree.Struct,
) -> Plain | Text | Record:
    if isinstance(node, type_tree.Number):
        return _number(node.name)
    if isinstance(node, type_tree.Stamp):
        return Plain(8, 4)
    if isinstance(node, type_tree.Text):
        return Text()
    slots = tuple(Slot(member.name, "", _ros1_node(member.node)) for member in node.members)
    return Record(node.name, slots, ())


def _default(node: Node, ros2: Ros2Type, default: DefaultValue | None) -> list[tuple[int, bytes]]:
    """Return a ROS 2 value as aligned pieces: the default of its field, or zero."""
    if isinstance(node, Array):
        values = default if isinstance(default, tuple) else (None,) * (node.length or 0)
        pieces = [(4, len(values).to_bytes(4, "little"))] if node.length is None else []
        return pieces + [piece for value in values for piece in _default(node.element, ros2, value)]
    if isinstance(node, Record):
        return [piece for slot in node.ros2_slots for piece in slot.default]
    value: ConstantValue | None = None if isinstance(default, tuple) else default
    if isinstance(node, Text):
        if node.is_wide:
            units = widen(str(value or "").encode())
            return [(4, (len(units) // UNIT_BYTES).to_bytes(4, "little")), (4, units)]
        raw = str(value or "").encode() + b"\0"
        return [(4, len(raw).to_bytes(4, "little")), (1, raw)]
    return [(node.alignment, struct.pack(f"<{_NUMBERS[ros2.base]}", value or 0))]


def _spelling(name: str) -> str:
    return name.lower().replace("_", "")


def _listed(names: list[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)
