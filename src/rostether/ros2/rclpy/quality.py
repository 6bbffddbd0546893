"""Quality of service of this node's endpoints, and the reasons for mismatches.

A subscriber receives nothing from a publisher that offers less than it requests. So the publishers of this
node offer the maximum, and its subscribers request what all current publishers offer.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

from rostether.msgdef.interface import MessageType
from rostether.ros2.endpoint_info import connection_fields
from rostether.ros2.rclpy.installation import load_rclpy
from rostether.ros2.rclpy.view import node_name_of

# Messages kept until subscribers acknowledge them: 50 ms at the highest rate. So a machine that is busy for a
# moment loses no burst from a board.
PUBLISHER_DEPTH: Final = 1000

# Messages kept until the executor's thread reads them: 200 ms at that rate. Creating a node, which blocks the
# thread, takes less.
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


class SubscriberQuality(NamedTuple):
    """The quality of service that a subscriber requests."""

    is_reliable: bool
    is_latched: bool


def subscriber_quality(publishers: Sequence[Any]) -> SubscriberQuality:
    """Return the strictest quality that all publishers (rclpy endpoint infos) offer, reliable for none."""
    return SubscriberQuality(
        is_reliable=all(each.qos_profile.reliability.name != "BEST_EFFORT" for each in publishers),
        is_latched=bool(publishers) and all(map(is_latching, publishers)),
    )


def rosout_profile() -> Any:
    """Return the profile of rcl's publishers of /rosout."""
    lifespan = load_rclpy().duration.Duration(seconds=ROSOUT_LIFESPAN_S)
    return profile(ROSOUT_DEPTH, is_latched=True, lifespan=lifespan)


def profile(depth: int, *, is_reliable: bool = True, is_latched: bool = False, **others: Any) -> Any:
    """Return a profile of rclpy that keeps the last `depth` messages; `others` are more settings."""
    qos = load_rclpy().qos
    return qos.QoSProfile(
        history=qos.HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=qos.ReliabilityPolicy.RELIABLE if is_reliable else qos.ReliabilityPolicy.BEST_EFFORT,
        durability=qos.DurabilityPolicy.TRANSIENT_LOCAL if is_latched else qos.DurabilityPolicy.VOLATILE,
        **others,
    )


def is_latching(publisher: Any) -> bool:
    """Return whether a publisher (an endpoint info of rclpy) keeps messages for later subscribers."""
    return bool(publisher.qos_profile.durability.name == "TRANSIENT_LOCAL")


def publisher_fields(publisher: Any, topic: str, message_type: MessageType) -> dict[str, str]:
    """Return the connection header of a publisher, an endpoint info of rclpy."""
    return connection_fields(
        topic,
        message_type,
        node_name_of(publisher),
        is_latching=is_latching(publisher),
        reliability=publisher.qos_profile.reliability.name,
    )


def name_policy(event: Any) -> str:
    """Return the name of the policy in an incompatibility event, such as `durability`."""
    name = getattr(event.last_policy_kind, "name", str(event.last_policy_kind))
    return str(name).removeprefix("RMW_QOS_POLICY_").replace("_", " ").lower()
