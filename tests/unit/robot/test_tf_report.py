from __future__ import annotations

import pytest

from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.tf_report import (
    format_transform,
    frame_facts,
    frame_tree,
    frames_as_dot,
)
from rostether.robot.transform import StampedTransform, Transform, quaternion_from_rpy


@pytest.fixture
def buffer() -> TransformBuffer:
    buffer = TransformBuffer()
    for stamp in (1_000_000_000, 2_000_000_000):
        buffer.set_transform(StampedTransform("root", "b", stamp, Transform()), authority="/moving")
    buffer.set_transform(StampedTransform("root", "a", 1, Transform()), authority="/still", is_static=True)
    buffer.set_transform(StampedTransform("a", 'a"1', 1, Transform()), authority="/still", is_static=True)
    return buffer


def test_the_tree_is_below_its_root(buffer: TransformBuffer) -> None:
    assert list(frame_tree(buffer)) == [
        "root",
        "├─ a  (static, /still)",
        '│  └─ a"1  (static, /still)',
        "└─ b  (2.0 Hz, /moving)",
    ]


def test_frames_in_a_loop_are_marked() -> None:
    buffer = TransformBuffer()
    for parent, child in (("x", "y"), ("y", "x")):
        buffer.set_transform(StampedTransform(parent, child, 1, Transform()))
    lines = list(frame_tree(buffer))
    assert "loop" in lines[0]
    assert len(lines) == 3


def test_the_lines_of_a_long_chain_are_bounded() -> None:
    buffer = TransformBuffer()
    for level in range(2000):
        buffer.set_transform(StampedTransform(f"f{level}", f"f{level + 1}", 1, Transform()))
    lines = list(frame_tree(buffer))
    assert len(lines) == 2001, "no frame is shown as a loop"
    assert max(map(len, lines)) < 400


def test_dot_quotes_names(buffer: TransformBuffer) -> None:
    buffer.set_transform(StampedTransform("a", "\x1b\n\\", 1, Transform()), authority='/end"\\')
    text = frames_as_dot(buffer)
    assert '"a" -> "a\\"1"' in text
    assert '"a" -> "\\u001b\\n\\\\" [label="Broadcaster: /end\\"\\\\\\nAverage rate' in text


def test_the_facts_of_a_frame(buffer: TransformBuffer) -> None:
    moving = frame_facts(buffer)[0]
    assert (moving.frame, moving.rate_hz, moving.buffer_length_s, moving.is_static) == ("b", 2.0, 1.0, False)


def test_a_transform_as_tf_echo_prints_it() -> None:
    stamped = StampedTransform(
        "a", "b", 1_500_000_000, Transform((1.0, 2.0, 3.0), quaternion_from_rpy(0, 0, 1))
    )
    assert format_transform(stamped).splitlines() == [
        "At time 1.500",
        "- Translation: [1.000, 2.000, 3.000]",
        "- Rotation: in Quaternion [0.000, 0.000, 0.479, 0.878]",
        "            in RPY (radian) [0.000, -0.000, 1.000]",
        "            in RPY (degree) [0.000, -0.000, 57.296]",
    ]
