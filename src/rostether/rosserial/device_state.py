"""Whether a host has asked a device for its topics and still answers, as a table.

    state          input            next           what happens
    UNCONFIGURED   TOPIC_REQUEST    CONFIGURED     ask for the time, announce every endpoint
    UNCONFIGURED   WRONG_VERSION    UNCONFIGURED   ask for the time: the host must request the topics
    CONFIGURED     TOPIC_REQUEST    CONFIGURED     ask for the time, announce every endpoint
    CONFIGURED     TIME_DUE         CONFIGURED     ask for the time
    CONFIGURED     TIME_LOST        UNCONFIGURED   no answer for 11 s
    CONFIGURED     STOP             UNCONFIGURED   the host leaves

While unconfigured nothing is sent on user ids; logs, parameter requests and time answers work in both states.
"""

from __future__ import annotations

from enum import Enum, auto


class State(Enum):
    """Whether a host has requested the topics and still answers."""

    UNCONFIGURED = auto()
    CONFIGURED = auto()


class Input(Enum):
    """The inputs of the state table."""

    TOPIC_REQUEST = auto()
    WRONG_VERSION = auto()
    TIME_DUE = auto()
    TIME_LOST = auto()
    STOP = auto()


# All other pairs change nothing.
TRANSITIONS: dict[tuple[State, Input], tuple[State, tuple[str, ...]]] = {
    (State.UNCONFIGURED, Input.TOPIC_REQUEST): (State.CONFIGURED, ("ask_time", "announce")),
    (State.UNCONFIGURED, Input.WRONG_VERSION): (State.UNCONFIGURED, ("ask_time",)),
    (State.CONFIGURED, Input.TOPIC_REQUEST): (State.CONFIGURED, ("ask_time", "announce")),
    (State.CONFIGURED, Input.TIME_DUE): (State.CONFIGURED, ("ask_time",)),
    (State.CONFIGURED, Input.TIME_LOST): (State.UNCONFIGURED, ("fall_silent",)),
    (State.CONFIGURED, Input.STOP): (State.UNCONFIGURED, ("fall_silent",)),
}
