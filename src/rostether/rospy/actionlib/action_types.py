"""The common part of action clients and servers: the classes of an action, the names of states, the error."""

from __future__ import annotations

from typing import Any

from msgspec import Struct

from rostether.rospy.client.message import Message
from rostether.rospy.client.message_types import all_types

GoalID: Any = all_types().message_class("actionlib_msgs/GoalID")
GoalStatus: Any = all_types().message_class("actionlib_msgs/GoalStatus")
GoalStatusArray: Any = all_types().message_class("actionlib_msgs/GoalStatusArray")


class ActionException(Exception):
    """The type is not an action."""


class ActionClasses(Struct, frozen=True):
    """The classes that make up an action's class `NameAction`."""

    goal: type[Message]
    result: type[Message]
    feedback: type[Message]
    plain_result: type[Message]

    @classmethod
    def of(cls, action: Any) -> ActionClasses:
        """Return the parts of the class `action` of an .action file. Raises ActionException."""
        try:
            example = action()
            return cls(
                type(example.action_goal),
                type(example.action_result),
                type(example.action_feedback),
                type(example.action_result.result),
            )
        except AttributeError:
            raise ActionException(f"Type is not an action spec: {action}") from None


def name_of_state(C: Any, n: int) -> str:
    """Return the name of the constant in the class `C` with the value `n`, or NO_SUCH_STATE_n."""
    for name, value in vars(C).items():
        if isinstance(value, int) and value == n:
            return str(name)
    return f"NO_SUCH_STATE_{n}"


# Programs print GoalStatus.to_string(client.get_state()).
GoalStatus.to_string = classmethod(name_of_state)
