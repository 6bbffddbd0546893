"""Quality of service of the own publishers and subscribers, and the reasons for mismatches.

A subscriber gets nothing from a publisher that offers less than requested. So own publishers offer the most,
and own subscribers request what all current publishers offer.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import Any, Final

from rostether.msgdef.interface import MessageType
from rostether.ros2.rclpy.installation import load_rclpy

# Messages kept until subscribers acknowledge them: 50 ms at the highest rate, so that a burst from a board is
# not lost on a machine that is busy for a moment.
PUBLISHER_DEPTH: Final = 1000

# Messages kept until the executor's thread reads them: 200 ms at that rate, longer than creating a node.
SUBSCRIBER_DEPTH: Final = 4000

# A latched topic of ROS 1 sends only its last message to new subscribers.
LATCHED_DEPTH: Final = 1

# Requests and responses kept until the executor's thread reads them. With rclpy's default of 10, a burst of
# 20 loses half without an error at the caller. This is three times the limit of calls that wait for a board;
# 100 responses need 10 KB.
SERVICE_DEPTH: Final = 100

ROSOUT_DEPTH: Final = 1000
# As in rcl: later subscribers receive the last 1000 messages that are not older than 10 s.
ROSOUT_LIFESPAN_S: Final = 10


class SubscriberQuality(Enum):
    """The quality of service that a subscriber requests."""

    RELIABLE = "reliable"
    BEST_EFFORT = "best effort"
    RELIABLE_LATCHED = "reliable, transient local"
    BEST_EFFORT_LATCHED = "best effort, transient local"


def publisher_profile(*, latch: bool) -> Any:
    """Return the profile that a publisher offers."""
    qos = load_rclpy().qos
    durability = qos.DurabilityPolicy.TRANSIENT_LOCAL if latch else qos.DurabilityPolicy.VOLATILE
    return qos.QoSProfile(
        history=qos.HistoryPolicy.KEEP_LAST,
        depth=LATCHED_DEPTH if latch else PUBLISHER_DEPTH,
        reliability=qos.ReliabilityPolicy.RELIABLE,
        durability=durability,
    )


def subscriber_quality(publishers: Sequence[Any]) -> SubscriberQuality:
    """Return the most that all publishers (endpoint infos of rclpy) offer; reliable if there are none."""
    profiles = [publisher.qos_profile for publisher in publishers]
    is_reliable = all(profile.reliability.name != "BEST_EFFORT" for profile in profiles)
    is_latched = bool(profiles) and all(is_latching(publisher) for publisher in publishers)
    if is_latched:
        return SubscriberQuality.RELIABLE_LATCHED if is_reliable else SubscriberQuality.BEST_EFFORT_LATCHED
    return SubscriberQuality.RELIABLE if is_reliable else SubscriberQuality.BEST_EFFORT


def subscriber_profile(quality: SubscriberQuality) -> Any:
    """Return the profile of a subscriber."""
    qos = load_rclpy().qos
    is_latched = quality in (SubscriberQuality.RELIABLE_LATCHED, SubscriberQuality.BEST_EFFORT_LATCHED)
    is_reliable = quality in (SubscriberQuality.RELIABLE, SubscriberQuality.RELIABLE_LATCHED)
    return qos.QoSProfile(
        history=qos.HistoryPolicy.KEEP_LAST,
        depth=SUBSCRIBER_DEPTH,
        reliability=qos.ReliabilityPolicy.RELIABLE if is_reliable else qos.ReliabilityPolicy.BEST_EFFORT,
        durability=qos.DurabilityPolicy.TRANSIENT_LOCAL if is_latched else qos.DurabilityPolicy.VOLATILE,
    )


def service_profile() -> Any:
    """Return the profile of own servers and clients: rcl's with a longer queue (need not match)."""
    qos = load_rclpy().qos
    return qos.QoSProfile(
        history=qos.HistoryPolicy.KEEP_LAST,
        depth=SERVICE_DEPTH,
        reliability=qos.ReliabilityPolicy.RELIABLE,
        durability=qos.DurabilityPolicy.VOLATILE,
    )


def rosout_profile() -> Any:
    """Return the profile of rcl's publishers of /rosout."""
    qos = load_rclpy().qos
    duration = load_rclpy().duration
    return qos.QoSProfile(
        history=qos.HistoryPolicy.KEEP_LAST,
        depth=ROSOUT_DEPTH,
        reliability=qos.ReliabilityPolicy.RELIABLE,
        durability=qos.DurabilityPolicy.TRANSIENT_LOCAL,
        lifespan=duration.Duration(seconds=ROSOUT_LIFESPAN_S),
    )


def is_latching(publisher: Any) -> bool:
    """Return whether a publisher (an endpoint info of rclpy) keeps messages for later subscribers."""
    return bool(publisher.qos_profile.durability.name == "TRANSIENT_LOCAL")


def connection_fields(
    publisher: Any, node_name: str, topic: str, message_type: MessageType
) -> dict[str, str]:
    """Return the fields of a ROS 1 publisher's header for an endpoint info, and its reliability."""
    return {
        "callerid": node_name,
        "topic": topic,
        "type": message_type.name,
        "md5sum": message_type.md5sum,
        "message_definition": message_type.definition,
        "latching": "1" if is_latching(publisher) else "0",
        "reliability": publisher.qos_profile.reliability.name.lower(),
    }


def name_policy(event: Any) -> str:
    """Return the policy that an incompatibility event is about, as `durability`."""
    name = getattr(event.last_policy_kind, "name", str(event.last_policy_kind))
    return str(name).removeprefix("RMW_QOS_POLICY_").replace("_", " ").lower()
