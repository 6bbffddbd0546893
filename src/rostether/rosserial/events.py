"""The reports of links, as frozen values. Directions and roles are the device's.

`HostEvent` lists the reports of a `HostLink`, `DeviceEvent` those of a `DeviceLink`.
"""

from __future__ import annotations

from enum import Enum
from typing import TypeAlias

from msgspec import Struct

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


class MessagesReceived(Struct, frozen=True):
    """Payloads of one announced topic id, in order; at most one event per topic id and chunk."""

    topic_id: int
    payloads: list[bytes]


class TopicAnnounced(Struct, frozen=True):
    """The device has a topic; reported again for the same id only when something about it changed."""

    role: TopicRole
    info: TopicInfo


class TopicWithdrawn(Struct, frozen=True):
    """A topic announced earlier has been removed from the device."""

    role: TopicRole
    info: TopicInfo


class ServiceAnnounced(Struct, frozen=True):
    """The device serves or calls a service; reported once its request and its response are known.

    The `md5sum` of `request` and `response` is that of their message, not the service's.
    For a SERVER the host sends on `request.topic_id`, for a CLIENT on `response.topic_id`.
    """

    role: ServiceRole
    name: str
    type: str
    request: TopicInfo
    response: TopicInfo


class ServiceWithdrawn(Struct, frozen=True):
    """A service announced earlier has been removed from the device."""

    role: ServiceRole
    name: str
    type: str
    request: TopicInfo
    response: TopicInfo


class AnnouncementRefused(Struct, frozen=True):
    """The device announced twice an endpoint that cannot be bridged; reported once for each.

    `reason` explains the problem and what to change in the sketch.
    """

    topic_name: str
    message_type: str
    reason: str


class NegotiationSettled(Struct, frozen=True):
    """The set of endpoints is considered complete: another request brought nothing new."""


class TimeRequested(Struct, frozen=True):
    """The device requests the time: call `HostLink.answer_time`."""


class LogReceived(Struct, frozen=True):
    """The device logs a line."""

    level: LogLevel
    text: str


class ParameterRequested(Struct, frozen=True):
    """The device requests a parameter and waits: always call `HostLink.answer_parameter`."""

    name: str


class FrameDiscarded(Struct, frozen=True):
    """Rejected bytes: `data` has them in order, and none is also part of a frame.

    `topic_id` is the reserved id of a packet with a wrong layout.
    """

    reason: DiscardReason
    data: bytes
    topic_id: int | None = None


class UnknownTopicId(Struct, frozen=True):
    """`count` messages arrived on a topic id that was never announced; the link requests the topics again."""

    topic_id: int
    count: int = 1


class ControlFlood(Struct, frozen=True):
    """The device sends too much on a reserved topic id; `count` frames were dropped unread."""

    topic_id: int
    count: int


class DeviceReset(Struct, frozen=True):
    """The device lost its configuration (reset, or no time answers); the link requests its topics.

    Until it has announced a topic id again, nothing may be sent on it.
    """


class DeviceSilent(Struct, frozen=True):
    """No valid frame for longer than a healthy device stays silent; reported once per silence."""

    silence_s: float


class ProtocolDetected(Struct, frozen=True):
    """The device uses protocol version 1 or 2; reported once, and again only if it changes."""

    version: int


class TopicsRequested(Struct, frozen=True):
    """A host requested the topics; they were announced and the device is configured now."""


class Unconfigured(Struct, frozen=True):
    """The device received no time answer for too long, or a stop request: it no longer publishes."""


class TimeAnswered(Struct, frozen=True):
    """The host sent its time."""

    time: Time


class ParameterReceived(Struct, frozen=True):
    """The answer to `DeviceLink.request_parameter`; all lists empty means the parameter does not exist."""

    name: str
    ints: tuple[int, ...]
    floats: tuple[float, ...]
    strings: tuple[str, ...]


class ParameterTimedOut(Struct, frozen=True):
    """No answer to `DeviceLink.request_parameter` arrived in time."""

    name: str


class StopReceived(Struct, frozen=True):
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
