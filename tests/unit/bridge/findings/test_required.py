from __future__ import annotations

from rostether.bridge.findings.finding import Code
from rostether.bridge.findings.required import RequiredTopics
from rostether.errors import InvalidNameError


def resolve(name: str) -> str:
    if " " in name:
        raise InvalidNameError(name)
    return name if name.startswith("/") else f"/{name}"


def test_nothing_is_required_by_default() -> None:
    required = RequiredTopics()
    required.compare([])
    assert list(required.find()) == []


def test_names_are_compared_in_full() -> None:
    required = RequiredTopics(["imu", "/odom"], resolve)
    assert list(required.find()) == []
    required.compare(["/imu", "odom", "a b"])
    assert list(required.find()) == []


def test_missing_topics_are_named_with_the_announced_ones() -> None:
    required = RequiredTopics(["imu", "/odom"], resolve)
    required.compare(["imu", "chatter"])
    (finding,) = required.find()
    assert finding.code is Code.MISSING_TOPIC
    assert "does not announce /odom, which" in finding.seen
    assert "it announces imu, chatter" in finding.seen
    required.compare([])
    assert "it announces no topic" in next(required.find()).seen
    required.compare([f"t{number}" for number in range(20)])
    assert "and 12 more" in next(required.find()).seen
    required.forget()
    assert list(required.find()) == []
