from __future__ import annotations

import pytest

from rostether.ros2.qos import (
    DEFAULT_QOS,
    LATCHED_QOS,
    Durability,
    History,
    Qos,
    Reliability,
)
from rostether.ros2.zenoh.tokens import format_qos, parse_qos

TEXTS = [
    (DEFAULT_QOS, "::,10:,:,:,,"),
    (Qos(Reliability.BEST_EFFORT, depth=5), "2::,5:,:,:,,"),
    (LATCHED_QOS, ":1:,1:,:,:,,"),
    (Qos(depth=42), "::,:,:,:,,"),
    (Qos(history=History.KEEP_ALL, depth=0), "::2,0:,:,:,,"),
]


@pytest.mark.parametrize(("qos", "text"), TEXTS)
def test_defaults_are_empty(qos: Qos, text: str) -> None:
    assert format_qos(qos) == text
    assert parse_qos(text) == qos


@pytest.mark.parametrize(
    ("text", "qos"),
    [
        ("", Qos(depth=42)),
        ("1:2:1,7:1,5:2,0:1,9,9", Qos(depth=7)),
        ("0:0:0,0", Qos(depth=0)),
        (
            "2:1:2,:,:,:,,:more",
            Qos(Reliability.BEST_EFFORT, Durability.TRANSIENT_LOCAL, History.KEEP_ALL, 42),
        ),
        ("x:y:z,w", Qos(depth=42)),
        ("::,²:", Qos(depth=42)),
        ("::,-3:", Qos(depth=42)),
    ],
)
def test_every_text_of_a_peer_is_read(text: str, qos: Qos) -> None:
    assert parse_qos(text) == qos


def test_a_depth_of_any_length_is_read() -> None:
    assert parse_qos(f"1:1:1,{'9' * 5000}").depth == Qos(depth=42).depth
