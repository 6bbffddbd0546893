from __future__ import annotations

import pytest
import yaml

from rostether.recording.ros2_qos import is_latching, offered, profiles_text, read_profiles


def test_numbers_of_older_recordings_become_words() -> None:
    text = "- history: 1\n  depth: 3\n  reliability: 2\n  durability: 1\n  liveliness: 1\n"
    (profile,) = read_profiles(text)
    assert profile == {
        "history": "keep_last",
        "depth": 3,
        "reliability": "best_effort",
        "durability": "transient_local",
        "liveliness": "automatic",
    }
    assert is_latching([profile])
    assert read_profiles(profiles_text([profile])) == [profile]


def test_the_profile_of_a_ros1_publisher() -> None:
    (latched,) = yaml.safe_load(offered(is_latching=True))
    (plain,) = yaml.safe_load(offered(is_latching=False, is_best_effort=True))
    assert (latched["durability"], latched["depth"], latched["reliability"]) == (
        "transient_local",
        1,
        "reliable",
    )
    assert (plain["durability"], plain["reliability"]) == ("volatile", "best_effort")
    assert plain["deadline"] == {"sec": 9223372036, "nsec": 854775807}
    assert profiles_text([]) == ""


@pytest.mark.parametrize("stored", [None, 3, "", "{", "a: 1", "[1, [2]]", "- *nobody", "[" * 50_000])
def test_invalid_profiles_are_omitted(stored: object) -> None:
    assert read_profiles(stored) == []
