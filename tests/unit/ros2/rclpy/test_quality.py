"""What a subscriber asks for, by what the publishers that are there offer."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from rostether.ros2.rclpy.quality import Wish, name_policy, subscriber_wish


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
    ("publishers", "wish"),
    [
        ((), Wish.RELIABLE),
        (("rv",), Wish.RELIABLE),
        (("rl", "rl"), Wish.RELIABLE_LATCHED),
        (("rl", "rv"), Wish.RELIABLE),
        (("rv", "bv"), Wish.BEST_EFFORT),
        (("rl", "bl"), Wish.BEST_EFFORT_LATCHED),
        (("rl", "bv"), Wish.BEST_EFFORT),
    ],
)
def test_the_most_that_all_offer(publishers: tuple[str, ...], wish: Wish) -> None:
    assert subscriber_wish(offers(*publishers)) is wish


def test_policies_have_names() -> None:
    kind = SimpleNamespace(name="RMW_QOS_POLICY_LIVELINESS_LEASE_DURATION")
    assert name_policy(SimpleNamespace(last_policy_kind=kind)) == "liveliness lease duration"
