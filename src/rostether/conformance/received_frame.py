"""Data from a client: frames, announcements and strings, and how they deviate from the protocol."""

from __future__ import annotations

import struct
from typing import NamedTuple

from rostether.rosserial import topic_id as ids
from rostether.rosserial.packets import TIME_BYTES, TopicInfo


class Deviation(Exception):  # noqa: N818 - a finding, not an error of this program
    """A difference between the client's behavior and the requirement of a case."""


class Frame(NamedTuple):
    """A valid frame from the client."""

    topic_id: int
    payload: bytes


class Announcement(NamedTuple):
    """One announcement: its reserved id, its payload, and its content if its layout is right."""

    kind: int
    payload: bytes
    info: TopicInfo | None

    @property
    def name(self) -> str:
        """The announced name, without a leading slash."""
        return "" if self.info is None else self.info.topic_name.removeprefix("/")


def is_time_request(frame: Frame) -> bool:
    """Return whether a frame is a time request."""
    return frame.topic_id == ids.TIME and len(frame.payload) in (0, TIME_BYTES)


def text_payload(text: str | bytes) -> bytes:
    """Return the payload of a std_msgs/String."""
    data = text.encode() if isinstance(text, str) else text
    return struct.pack("<I", len(data)) + data


def read_text(payload: bytes) -> str:
    """Return the text of a std_msgs/String. Raises Deviation if the layout is wrong."""
    if len(payload) < 4 or len(payload) != 4 + int.from_bytes(payload[:4], "little"):
        raise Deviation(f"{payload[:32].hex(' ')} is not a std_msgs/String")
    return payload[4:].decode("utf-8", "replace")


def is_announcement(frame: Frame) -> bool:
    """Return whether a frame announces an endpoint."""
    return frame.topic_id in ids.ANNOUNCEMENTS and bool(frame.payload)


def read_announcement(frame: Frame) -> Announcement:
    """Return the announcement in a frame; its `info` is None if the layout is wrong."""
    return Announcement(frame.topic_id, frame.payload, TopicInfo.read(frame.payload))
