"""What a subscriber asks for, by what the publishers that are there offer."""

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
        ((), SubscriberQuality.RELIABLE),
        (("rv",), SubscriberQuality.RELIABLE),
        (("rl", "rl"), SubscriberQuality.RELIABLE_LATCHED),
        (("rl", "rv"), SubscriberQuality.RELIABLE),
        (("rv", "bv"), SubscriberQuality.BEST_EFFORT),
        (("rl", "bl"), SubscriberQuality.BEST_EFFORT_LATCHED),
        (("rl", "bv"), SubscriberQuality.BEST_EFFORT),
    ],
)
def test_the_most_that_all_offer(publishers: tuple[str, ...], quality: SubscriberQuality) -> None:
    assert subscriber_quality(offers(*publishers)) is quality


def test_policies_have_names() -> None:
    kind = SimpleNamespace(name="RMW_QOS_POLICY_LIVELINESS_LEASE_DURATION")
    assert name_policy(SimpleNamespace(last_policy_kind=kind)) == "liveliness lease duration"
