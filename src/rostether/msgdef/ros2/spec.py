"""The content of a ROS 2 .msg, .srv or .action text, as values.

Type names are `package/msg/Name` and `package/srv/Name`, as in ROS 2; the messages of a service are
`package/srv/Name_Request` and `package/srv/Name_Response`. The parts of an action are
`package/action/Name_Goal`, `_Result` and `_Feedback`.
"""

from __future__ import annotations

from typing import TypeAlias

from msgspec import Struct

ConstantValue: TypeAlias = bool | int | float | str
DefaultValue: TypeAlias = ConstantValue | tuple[ConstantValue, ...]


class Ros2Type(Struct, frozen=True):
    """The type of one field.

    `base` is a primitive (`bool byte char int8 ... uint64 float32 float64 string wstring`) or a full
    `package/msg/Name`. `string_bound` is the maximum number of characters of a bounded string. An array is
    fixed when it has a `length`, else a sequence of at most `bound` items (None: any number).
    """

    base: str
    is_array: bool = False
    length: int | None = None
    bound: int | None = None
    string_bound: int | None = None

    def __str__(self) -> str:
        base = self.base if self.string_bound is None else f"{self.base}<={self.string_bound}"
        if not self.is_array:
            return base
        if self.length is not None:
            return f"{base}[{self.length}]"
        return f"{base}[{'' if self.bound is None else f'<={self.bound}'}]"


class Ros2Field(Struct, frozen=True):
    """One named field; `default` is None if the text has none."""

    type: Ros2Type
    name: str
    default: DefaultValue | None = None


class Ros2Constant(Struct, frozen=True):
    """One constant and its parsed value."""

    type: str
    name: str
    value: ConstantValue


class Ros2Message(Struct, frozen=True):
    """One message; `kind` is `msg`, `srv` for a part of a service, or `action` for a part of an action."""

    package: str
    kind: str
    name: str
    fields: tuple[Ros2Field, ...]
    constants: tuple[Ros2Constant, ...] = ()

    @property
    def full_name(self) -> str:
        """The name `package/kind/Name`."""
        return f"{self.package}/{self.kind}/{self.name}"

    @property
    def parts(self) -> tuple[Ros2Message, ...]:
        """The messages of the definition: this one."""
        return (self,)


class Ros2Service(Struct, frozen=True):
    """One service definition; `kind` is `action` for a service of an action."""

    package: str
    name: str
    request: Ros2Message
    response: Ros2Message
    kind: str = "srv"

    @property
    def full_name(self) -> str:
        """The name `package/kind/Name`."""
        return f"{self.package}/{self.kind}/{self.name}"

    @property
    def parts(self) -> tuple[Ros2Message, ...]:
        """The messages of the definition, in their order."""
        return (self.request, self.response)


class Ros2Action(Struct, frozen=True):
    """One action definition: the messages of its goal, result and feedback."""

    package: str
    name: str
    goal: Ros2Message
    result: Ros2Message
    feedback: Ros2Message

    @property
    def full_name(self) -> str:
        """The name `package/action/Name`."""
        return f"{self.package}/action/{self.name}"

    @property
    def parts(self) -> tuple[Ros2Message, ...]:
        """The messages of the definition, in their order."""
        return (self.goal, self.result, self.feedback)
