"""The limits of a host link, and its name in the log."""

from __future__ import annotations

from collections.abc import Callable

from msgspec import Struct

from rostether.rosserial.frame import MAX_PAYLOAD_BYTES
from rostether.rosserial.packets import TopicInfo


class HostLinkConfig(Struct, frozen=True):
    """Limits of a host link; the defaults suit all known boards."""

    # The maximum of a frame: Linux devices send images in one frame.
    max_payload_bytes: int = MAX_PAYLOAD_BYTES
    # The established library has at most 50; each costs a registration on the ROS side.
    max_endpoints: int = 256
    # Returns the size of every message of a topic if its type has a fixed size, else None.
    fixed_size: Callable[[TopicInfo], int | None] | None = None
    # The device's name in the log.
    name: str = "a board"
