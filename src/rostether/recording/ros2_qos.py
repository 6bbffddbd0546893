"""Quality of service in ROS 2 recordings: a YAML list with the profile of each publisher of a topic.

Since Jazzy, policies are words; earlier releases use the numbers of rmw.
"""

from __future__ import annotations

from typing import Any

import yaml

from rostether.bounded_yaml import YamlError, load

_WORDS = {
    "history": ("system_default", "keep_last", "keep_all", "unknown"),
    "reliability": ("system_default", "reliable", "best_effort", "unknown", "best_available"),
    "durability": ("system_default", "transient_local", "volatile", "unknown", "best_available"),
    "liveliness": (
        "system_default",
        "automatic",
        "manual_by_node",
        "manual_by_topic",
        "unknown",
        "best_available",
    ),
}
# The largest duration of rmw: 2^63 - 1 ns.
_INFINITE = {"sec": 9223372036, "nsec": 854775807}
# The limit of the text of a topic; a publisher needs about 400 characters.
MAX_CHARACTERS = 1 << 18
# Files are untrusted; if a topic has more publishers, only the first profiles are read.
MAX_PROFILES = 1000


def offered(*, is_latching: bool, is_best_effort: bool = False) -> str:
    """Return the QoS text for a ROS 1 publisher, or for a publisher whose other settings are unknown."""
    return profiles_text(
        [
            {
                "history": "keep_last",
                "depth": 1 if is_latching else 10,
                "reliability": "best_effort" if is_best_effort else "reliable",
                "durability": "transient_local" if is_latching else "volatile",
                "deadline": dict(_INFINITE),
                "lifespan": dict(_INFINITE),
                "liveliness": "automatic",
                "liveliness_lease_duration": dict(_INFINITE),
                "avoid_ros_namespace_conventions": False,
            }
        ]
    )


def read_profiles(stored: object) -> list[dict[str, Any]]:
    """Return the profiles in a text or list, with policies as words; empty if they are invalid."""
    if isinstance(stored, str):
        try:
            stored = load(stored[:MAX_CHARACTERS])
        except YamlError:
            return []
    if not isinstance(stored, list):
        return []
    return [_with_names(each) for each in stored[:MAX_PROFILES] if isinstance(each, dict)]


def profiles_text(profiles: list[dict[str, Any]]) -> str:
    """Return profiles as the text for channels and tables; empty without profiles."""
    return yaml.safe_dump(profiles, sort_keys=False).strip() if profiles else ""


def is_latching(profiles: list[dict[str, Any]]) -> bool:
    """Return whether one of the publishers was latched in terms of ROS 1."""
    return any(each.get("durability") == "transient_local" for each in profiles)


def _with_names(profile: dict[str, Any]) -> dict[str, Any]:
    words = dict(profile)
    for key, names in _WORDS.items():
        value = words.get(key)
        if isinstance(value, int) and 0 <= value < len(names):
            words[key] = names[value]
    return words
