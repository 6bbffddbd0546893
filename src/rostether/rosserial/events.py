"""The reports of links, as frozen values. Directions and roles are the device's.

`HostLink` reports: MessagesReceived, TopicAnnounced, TopicWithdrawn, ServiceAnnounced, ServiceWithdrawn,
AnnouncementRefused, NegotiationSettled, TimeRequested, LogReceived, ParameterRequested, FrameDiscarded,
UnknownTopicId, ControlFlood, DeviceReset, DeviceSilent, ProtocolDetected.

`DeviceLink` reports: MessagesReceived, TopicsRequested, Unconfigured, TimeAnswered, ParameterReceived,
ParameterTimedOut, StopReceived, FrameDiscarded, UnknownTopicId.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import TypeAlias

from rostether.rosserial.packets import LogLevel, TopicInfo
from rostether.rostime import Time


class TopicRole(Enum):
    """The device's role for a topic: PUBLISHER sends to ROS, SUBSCRIBER receives from ROS."""

    PUBLISHER = "publisher"
    SUBSCRIBER = "subscriber"


class ServiceRole(Enum):
    """The device's role for a service: SERVER answers calls from ROS, CLIENT calls a service of ROS."""

    SERVER = "service server"
    CLIENT = "service client"


class DiscardReason(Enum):
    """Why bytes were discarded."""

    NOISE = "bytes outside any frame"
    VERSION = "sync byte followed by another protocol version"
    LENGTH_CHECKSUM = "frame header with a wrong length checksum"
    PAYLOAD_CHECKSUM = "frame with a wrong payload checksum"
    TOO_LONG = "frame longer than the limit"
    UNFINISHED = "incomplete frame"
    PACKET = "control packet with a wrong layout"
    UNEXPECTED = "frame with a topic id that is invalid in this direction"
    REFUSED = "implausible announcement"
    TOO_MANY = "announcement over the limit of endpoints"


# The reasons that show that the line damages frames.
DAMAGE = frozenset({DiscardReason.LENGTH_CHECKSUM, DiscardReason.PAYLOAD_CHECKSUM, DiscardReason.PACKET})


@dataclass(frozen=True, slots=True)
class MessagesReceived:
    """Payloads of one announced topic id, in order; at most one event for each topic id a chunk."""

    topic_id: int
    payloads: list[bytes]


@dataclass(frozen=True, slots=True)
class TopicAnnounced:
    """The device has a topic; reported again for the same id only when something about it changed."""

    role: TopicRole
    info: TopicInfo


@dataclass(frozen=True, slots=True)
class TopicWithdrawn:
    """A topic announced earlier has been removed from the device."""

    role: TopicRole
    info: TopicInfo


@dataclass(frozen=True, slots=True)
class ServiceAnnounced:
    """The device serves or calls a service; reported once its request and its response are known.

    The `md5sum` of `request` and `response` is that of their message, not the service's.
    For a SERVER the host sends on `request.topic_id`, for a CLIENT on `response.topic_id`.
    """

    role: ServiceRole
    name: str
    type: str
    request: TopicInfo
    response: TopicInfo


@dataclass(frozen=True, slots=True)
class ServiceWithdrawn:
    """A service announced earlier has been removed from the device."""

    role: ServiceRole
    name: str
    type: str
    request: TopicInfo
    response: TopicInfo


@dataclass(frozen=True, slots=True)
class AnnouncementRefused:
    """The device announced twice an endpoint that cannot be bridged; reported once for each.

    `reason` explains the problem and what to change in the sketch.
    """

    topic_name: str
    message_type: str
    reason: str


@dataclass(frozen=True, slots=True)
class NegotiationSettled:
    """The set of endpoints is considered complete: asked again, the device announced nothing new."""


@dataclass(frozen=True, slots=True)
class TimeRequested:
    """The device requests the time: call `HostLink.answer_time`."""


@dataclass(frozen=True, slots=True)
class LogReceived:
    """The device logs a line."""

    level: LogLevel
    text: str


@dataclass(frozen=True, slots=True)
class ParameterRequested:
    """The device requests a parameter and waits: always call `HostLink.answer_parameter`."""

    name: str


@dataclass(frozen=True, slots=True)
class FrameDiscarded:
    """Rejected bytes: `data` has them in order, and none is also part of a frame.

    `topic_id` is the reserved id of a packet with a wrong layout.
    """

    reason: DiscardReason
    data: bytes
    topic_id: int | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class UnknownTopicId:
    """`count` messages arrived on a topic id that was never announced; the link asks for the topics again."""

    topic_id: int
    count: int = 1


@dataclass(frozen=True, slots=True)
class ControlFlood:
    """The device sends too much on a reserved topic id; `count` frames were dropped unread."""

    topic_id: int
    count: int


@dataclass(frozen=True, slots=True)
class DeviceReset:
    """The device lost its configuration (reset, or no time answers); the link requests its topics.

    Until it has announced a topic id again, nothing may be sent on it.
    """


@dataclass(frozen=True, slots=True)
class DeviceSilent:
    """No valid frame for longer than a healthy device stays silent; reported once per silence."""

    silence_s: float


@dataclass(frozen=True, slots=True)
class ProtocolDetected:
    """The device uses protocol version 1 or 2; reported once, and again only if it changes."""

    version: int


@dataclass(frozen=True, slots=True)
class TopicsRequested:
    """A host asked for the topics; they were announced and the device is configured now."""


@dataclass(frozen=True, slots=True)
class Unconfigured:
    """The device received no time answer for too long, or a stop request: it no longer publishes."""


@dataclass(frozen=True, slots=True)
class TimeAnswered:
    """The host sent its time."""

    time: Time


@dataclass(frozen=True, slots=True)
class ParameterReceived:
    """The answer to `DeviceLink.request_parameter`; all lists empty means the parameter does not exist."""

    name: str
    ints: tuple[int, ...]
    floats: tuple[float, ...]
    strings: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ParameterTimedOut:
    """No answer to `DeviceLink.request_parameter` arrived in time."""

    name: str


@dataclass(frozen=True, slots=True)
class StopReceived:
    """The host leaves and asks the device to stop sending."""


HostEvent: TypeAlias = (
    MessagesReceived
    | TopicAnnounced
    | TopicWithdrawn
    | ServiceAnnounced
    | ServiceWithdrawn
    | AnnouncementRefused
    | NegotiationSettled
    | TimeRequested
    | LogReceived
    | ParameterRequested
    | FrameDiscarded
    | UnknownTopicId
    | ControlFlood
    | DeviceReset
    | DeviceSilent
    | ProtocolDetected
)
DeviceEvent: TypeAlias = (
    MessagesReceived
    | TopicsRequested
    | Unconfigured
    | TimeAnswered
    | ParameterReceived
    | ParameterTimedOut
    | StopReceived
    | FrameDiscarded
    | UnknownTopicId
)
