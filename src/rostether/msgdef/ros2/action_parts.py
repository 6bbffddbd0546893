"""The messages and services of an action on a ROS 2 graph.

    <action>/_action/send_goal     service   Name_SendGoal
    <action>/_action/get_result    service   Name_GetResult
    <action>/_action/cancel_goal   service   action_msgs/srv/CancelGoal
    <action>/_action/feedback      topic     Name_FeedbackMessage
    <action>/_action/status        topic     action_msgs/msg/GoalStatusArray

Source: the design document "Actions" of ROS 2, and rosidl_parser, which generates the parts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from msgspec import Struct

from rostether.msgdef.ros2.parse import REQUEST_SUFFIX, RESPONSE_SUFFIX
from rostether.msgdef.ros2.spec import Ros2Action, Ros2Field, Ros2Message, Ros2Service, Ros2Type

SEND_GOAL, GET_RESULT, FEEDBACK_MESSAGE = "_SendGoal", "_GetResult", "_FeedbackMessage"

_SERVICES = (SEND_GOAL, GET_RESULT)
# The longer ones first.
_SUFFIXES = (
    *(service + suffix for service in _SERVICES for suffix in (REQUEST_SUFFIX, RESPONSE_SUFFIX)),
    *_SERVICES,
    FEEDBACK_MESSAGE,
    "_Goal",
    "_Result",
    "_Feedback",
)
_GOAL_ID = Ros2Field(Ros2Type("unique_identifier_msgs/msg/UUID"), "goal_id")


class ActionParts(Struct, frozen=True):
    """The parts of an action on the graph."""

    action: Ros2Action
    send_goal: Ros2Service
    get_result: Ros2Service
    feedback_message: Ros2Message

    @property
    def services(self) -> tuple[Ros2Service, ...]:
        """The services with types of the action."""
        return (self.send_goal, self.get_result)

    def messages(self) -> Iterator[Ros2Message]:
        """Yield all messages, including requests and responses."""
        yield from (*self.action.parts, self.feedback_message)
        for service in self.services:
            yield from service.parts


def action_parts(action: Ros2Action) -> ActionParts:
    """Return the parts of an action."""
    goal = Ros2Field(Ros2Type(action.goal.full_name), "goal")
    accepted = [
        Ros2Field(Ros2Type("bool"), "accepted"),
        Ros2Field(Ros2Type("builtin_interfaces/msg/Time"), "stamp"),
    ]
    result = [Ros2Field(Ros2Type("int8"), "status"), Ros2Field(Ros2Type(action.result.full_name), "result")]
    feedback = Ros2Field(Ros2Type(action.feedback.full_name), "feedback")
    return ActionParts(
        action,
        _service(action, SEND_GOAL, [_GOAL_ID, goal], accepted),
        _service(action, GET_RESULT, [_GOAL_ID], result),
        Ros2Message(action.package, "action", action.name + FEEDBACK_MESSAGE, (_GOAL_ID, feedback)),
    )


def action_of_part(name: str) -> str:
    """Return the action of a part: `Fibonacci_Goal` -> `Fibonacci`; other names are unchanged."""
    for suffix in _SUFFIXES:
        if name.endswith(suffix):
            return name.removesuffix(suffix)
    return name


def _service(
    action: Ros2Action, suffix: str, request: Sequence[Ros2Field], response: Sequence[Ros2Field]
) -> Ros2Service:
    name = action.name + suffix
    return Ros2Service(
        action.package,
        name,
        Ros2Message(action.package, "action", name + REQUEST_SUFFIX, tuple(request)),
        Ros2Message(action.package, "action", name + RESPONSE_SUFFIX, tuple(response)),
        "action",
    )
