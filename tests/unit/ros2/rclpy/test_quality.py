"""The quality of service that a subscriber requests, depending on the publishers."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from rostether.ros2.rclpy.quality import SubscriberQuality, name_policy, subscriber_quality


def offers(*words: str) -> list[SimpleNamespace]:
    return [
        SimpleNamespace(
            qos_profile=SimpleNamespace(
                reliability=SimpleNamespace(name="BEST_EFFORT" if "b" in word else "RELIABLE"),
                durability=SimpleNamespace(name="TRANSIENT_LOCAL" if "l" in word else "VOLATILE"),
            )
        )
        for word in words
    ]


# r: reliable, b: best effort, v: volatile, l: transient local ("latched")
@pytest.mark.parametrize(
    ("publishers", "quality"),
    [
        ((), SubscriberQuality(is_reliable=True, is_latched=False)),
        (("rv",), SubscriberQuality(is_reliable=True, is_latched=False)),
        (("rl", "rl"), SubscriberQuality(is_reliable=True, is_latched=True)),
        (("rl", "rv"), SubscriberQuality(is_reliable=True, is_latched=False)),
        (("rv", "bv"), SubscriberQuality(is_reliable=False, is_latched=False)),
        (("rl", "bl"), SubscriberQuality(is_reliable=False, is_latched=True)),
        (("rl", "bv"), SubscriberQuality(is_reliable=False, is_latched=False)),
    ],
)
def test_subscribers_request_what_all_publishers_offer(
    publishers: tuple[str, ...], quality: SubscriberQuality
) -> None:
    assert subscriber_quality(offers(*publishers)) == quality


def test_policies_are_named() -> None:
    kind = SimpleNamespace(name="RMW_QOS_POLICY_LIVELINESS_LEASE_DURATION")
    assert name_policy(SimpleNamespace(last_policy_kind=kind)) == "liveliness lease duration"
