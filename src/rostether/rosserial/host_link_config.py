"""The limits of a host link."""

from __future__ import annotations

from dataclasses import dataclass

from rostether.rosserial.frame import MAX_PAYLOAD_BYTES


@dataclass(frozen=True, slots=True)
class HostLinkConfig:
    """Limits of a host link; the defaults suit every board known."""

    max_payload_bytes: int = MAX_PAYLOAD_BYTES
    """All that a frame can say: Linux devices send images in one frame."""
    max_endpoints: int = 256
    """The established library has at most 50; each costs a registration on the ROS side."""
