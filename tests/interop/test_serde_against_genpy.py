"""genpy decodes encoded messages to the same values, for every bundled type that Debian also has."""

from __future__ import annotations

import functools
from typing import Any

import pytest

from interop.genpy_oracle import as_bytes, as_text, ask_genpy
from rostether.msgdef.registry import Registry
from rostether.serde.plain_form import to_plain
from rostether.serde.store import TypeStore
from unit.serde.random_messages import RandomMessages

STORE = TypeStore(Registry())
MESSAGES_PER_TYPE = 4
NOT_IN_DEBIAN = (
    "actionlib_tutorials/",
    "arduino_control/",
    "mearm_model/",
    "rosapi/",
    "rosserial_arduino/",
    "rosserial_msgs/",
    "rospy_tutorials/",
    "sensing_platform/",
    "tf/",
    "tf2_web_republisher/",
    "turtlebot3_msgs/",
)
TYPES = [name for name in STORE.registry.messages() if not name.startswith(NOT_IN_DEBIAN)]


@functools.cache
def compared() -> dict[str, list[tuple[bytes, dict[str, Any], Any]]]:
    """Return (payload, plain form, genpy's answer) of some messages of each type."""
    draw = RandomMessages(seed=2)
    cases = []
    for name in TYPES:
        codec = STORE.codec(name)
        for _ in range(MESSAGES_PER_TYPE):
            message = draw.message(codec)
            cases.append((name, codec.encode(message), to_plain(message)))
    requests = [{"task": "codec", "type": name, "payload": as_text(payload)} for name, payload, _ in cases]
    found: dict[str, list[tuple[bytes, dict[str, Any], Any]]] = {}
    for (name, payload, plain), answer in zip(cases, ask_genpy(requests), strict=True):
        found.setdefault(name, []).append((payload, plain, answer))
    return found


@pytest.mark.parametrize("name", TYPES)
def test_genpy_reads_the_same_values(name: str) -> None:
    for payload, plain, answer in compared()[name]:
        assert answer is not None
        assert answer["plain"] == plain
        assert as_bytes(answer["payload"]) == payload
