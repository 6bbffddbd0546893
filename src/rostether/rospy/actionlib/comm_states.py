"""The states of a goal in its client, and the transitions that a status from the server causes."""

from __future__ import annotations

from typing import ClassVar

from rostether.rospy.actionlib.action_types import GoalStatus, name_of_state


class CommState:
    """The states of a goal in its client."""

    WAITING_FOR_GOAL_ACK = 0
    PENDING = 1
    ACTIVE = 2
    WAITING_FOR_RESULT = 3
    WAITING_FOR_CANCEL_ACK = 4
    RECALLING = 5
    PREEMPTING = 6
    DONE = 7
    LOST = 8

    to_string: ClassVar = classmethod(name_of_state)


class TerminalState:
    """The final statuses of a goal."""

    RECALLED = GoalStatus.RECALLED
    REJECTED = GoalStatus.REJECTED
    PREEMPTED = GoalStatus.PREEMPTED
    ABORTED = GoalStatus.ABORTED
    SUCCEEDED = GoalStatus.SUCCEEDED
    LOST = GoalStatus.LOST

    to_string: ClassVar = classmethod(name_of_state)


_PENDING, _ACTIVE, _RESULT = CommState.PENDING, CommState.ACTIVE, CommState.WAITING_FOR_RESULT
_RECALLING, _PREEMPTING = CommState.RECALLING, CommState.PREEMPTING

_Transitions = dict[int, tuple[int, ...]]

# The states that a pending goal passes to reach each status. They include states that were too short to be
# published, because programs rely on them.
_FROM_PENDING: _Transitions = {
    GoalStatus.PENDING: (),
    GoalStatus.ACTIVE: (_ACTIVE,),
    GoalStatus.REJECTED: (_RESULT,),
    GoalStatus.RECALLING: (_RECALLING,),
    GoalStatus.RECALLED: (_RECALLING, _RESULT),
    GoalStatus.PREEMPTED: (_ACTIVE, _PREEMPTING, _RESULT),
    GoalStatus.SUCCEEDED: (_ACTIVE, _RESULT),
    GoalStatus.ABORTED: (_ACTIVE, _RESULT),
    GoalStatus.PREEMPTING: (_ACTIVE, _PREEMPTING),
}
_FROM_CANCELLING: _Transitions = {
    GoalStatus.REJECTED: (_RESULT,),
    GoalStatus.RECALLING: (_RECALLING,),
    GoalStatus.RECALLED: (_RECALLING, _RESULT),
    GoalStatus.PREEMPTED: (_PREEMPTING, _RESULT),
    GoalStatus.SUCCEEDED: (_PREEMPTING, _RESULT),
    GoalStatus.ABORTED: (_PREEMPTING, _RESULT),
    GoalStatus.PREEMPTING: (_PREEMPTING,),
}
_ENDED_BY_SERVER = (GoalStatus.REJECTED, GoalStatus.RECALLED, GoalStatus.PREEMPTED)
_ENDED_BY_WORK = (GoalStatus.SUCCEEDED, GoalStatus.ABORTED)

# The statuses of goals that have ended.
ENDED = frozenset((*_ENDED_BY_SERVER, *_ENDED_BY_WORK, GoalStatus.LOST))

# State -> status -> the states that follow. A missing status is invalid in that state.
TRANSITIONS: dict[int, _Transitions] = {
    CommState.WAITING_FOR_GOAL_ACK: {
        **_FROM_PENDING,
        GoalStatus.PENDING: (_PENDING,),
        GoalStatus.REJECTED: (_PENDING, _RESULT),
        GoalStatus.RECALLING: (_PENDING, _RECALLING),
        GoalStatus.RECALLED: (_PENDING, _RESULT),
    },
    CommState.PENDING: _FROM_PENDING,
    CommState.ACTIVE: {
        GoalStatus.ACTIVE: (),
        GoalStatus.PREEMPTED: (_PREEMPTING, _RESULT),
        GoalStatus.SUCCEEDED: (_RESULT,),
        GoalStatus.ABORTED: (_RESULT,),
        GoalStatus.PREEMPTING: (_PREEMPTING,),
    },
    CommState.WAITING_FOR_RESULT: dict.fromkeys((GoalStatus.ACTIVE, *_ENDED_BY_SERVER, *_ENDED_BY_WORK), ()),
    CommState.WAITING_FOR_CANCEL_ACK: {
        **_FROM_CANCELLING,
        GoalStatus.PENDING: (),
        GoalStatus.ACTIVE: (),
    },
    CommState.RECALLING: {
        **_FROM_CANCELLING,
        GoalStatus.RECALLING: (),
        GoalStatus.RECALLED: (_RESULT,),
    },
    CommState.PREEMPTING: {
        **dict.fromkeys((GoalStatus.PREEMPTED, *_ENDED_BY_WORK), (_RESULT,)),
        GoalStatus.PREEMPTING: (),
    },
    CommState.DONE: dict.fromkeys((*_ENDED_BY_SERVER, *_ENDED_BY_WORK), ()),
}
