from __future__ import annotations

import pytest

from rostether.errors import (
    ExtrapolationError,
    TransformError,
    UnconnectedFramesError,
    UnknownFrameError,
)
from rostether.robot import tf_buffer, tf_cache
from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.transform import StampedTransform, Transform

SECOND = 10**9


def at(parent: str, child: str, stamp_s: float, x: float = 1.0) -> StampedTransform:
    return StampedTransform(parent, child, round(stamp_s * SECOND), Transform((x, 0.0, 0.0)))


def place(buffer: TransformBuffer, target: str, source: str, time_s: float = 0) -> float:
    return buffer.lookup(target, source, round(time_s * SECOND)).transform.translation[0]


@pytest.fixture
def buffer() -> TransformBuffer:
    buffer = TransformBuffer()
    for stamp in (100, 101, 102):
        assert buffer.set_transform(at("root", "a", stamp, stamp - 100.0), authority="/n") == ""
    assert buffer.set_transform(at("a", "fixed", 1, 0.5), is_static=True) == ""
    assert buffer.set_transform(at("root", "b", 101.5, 10.0)) == ""
    return buffer


def test_transforms_are_interpolated(buffer: TransformBuffer) -> None:
    assert place(buffer, "root", "a", 100.25) == 0.25
    assert place(buffer, "a", "root", 100.25) == -0.25
    assert place(buffer, "root", "fixed", 101.5) == 2.0


def test_the_latest_time_is_common_to_all_steps(buffer: TransformBuffer) -> None:
    assert buffer.latest_common_time_ns("b", "fixed") == round(101.5 * SECOND)
    assert buffer.lookup("b", "fixed").stamp_ns == round(101.5 * SECOND)
    assert place(buffer, "b", "fixed") == 1.5 + 0.5 - 10.0
    assert buffer.latest_common_time_ns("a", "fixed") == 0
    assert buffer.latest_common_time_ns("a", "a") == 102 * SECOND


@pytest.mark.parametrize("time_s", [99.9, 102.1])
def test_times_outside_the_received_transforms_are_refused(buffer: TransformBuffer, time_s: float) -> None:
    with pytest.raises(ExtrapolationError, match="would require extrapolation"):
        place(buffer, "root", "a", time_s)


def test_a_single_transform_is_valid_only_at_its_time(buffer: TransformBuffer) -> None:
    assert place(buffer, "root", "b", 101.5) == 10.0
    with pytest.raises(ExtrapolationError, match=r"only time 101.500000000 is in the buffer"):
        place(buffer, "root", "b", 101.4)


def test_unknown_and_unconnected_frames(buffer: TransformBuffer) -> None:
    buffer.set_transform(at("island", "palm", 100))
    with pytest.raises(UnconnectedFramesError, match="two or more unconnected trees"):
        place(buffer, "root", "palm")
    with pytest.raises(UnknownFrameError, match='"nowhere" passed to lookupTransform'):
        place(buffer, "root", "nowhere")
    with pytest.raises(UnknownFrameError):
        buffer.chain("root", "nowhere")
    with pytest.raises(TransformError, match="cannot start with"):
        place(buffer, "/root", "a")


def test_a_loop_ends_with_an_error() -> None:
    buffer = TransformBuffer()
    for parent, child in (("x", "y"), ("y", "x"), ("y", "z")):
        assert buffer.set_transform(at(parent, child, 100)) == ""
    buffer.set_transform(at("p", "q", 100))
    with pytest.raises(UnknownFrameError, match="contains a loop"):
        place(buffer, "z", "q")
    with pytest.raises(UnknownFrameError, match="contains a loop"):
        place(buffer, "q", "z", 100)
    with pytest.raises(UnknownFrameError, match="contains a loop"):
        place(buffer, "z", "q", 100)


def test_lookup_error_returns_the_error_that_lookup_would_raise(buffer: TransformBuffer) -> None:
    assert buffer.lookup_error("root", "fixed") == ""
    assert "does not exist" in buffer.lookup_error("root", "nowhere")
    assert "extrapolation" in buffer.lookup_error("root", "a", 5)


def test_lookup_between_two_times_through_a_fixed_frame(buffer: TransformBuffer) -> None:
    moved = buffer.lookup_through("a", 100 * SECOND, "a", 102 * SECOND, "root")
    assert moved.transform.translation == (2.0, 0.0, 0.0)
    assert moved.stamp_ns == 100 * SECOND


def test_the_chain_and_the_frames(buffer: TransformBuffer) -> None:
    assert buffer.chain("b", "fixed") == ["fixed", "a", "root", "b"]
    assert buffer.frames == ["a", "root", "fixed", "b"]
    assert buffer.children == ["a", "fixed", "b"]


def test_a_frame_may_get_another_parent(buffer: TransformBuffer) -> None:
    buffer.set_transform(at("b", "a", 103, 1.0))
    assert place(buffer, "b", "a", 103) == 1.0
    # Between the two parents, the earlier one is valid.
    assert buffer.chain("b", "a") == ["a", "b"]


def test_clear_removes_transforms(buffer: TransformBuffer) -> None:
    buffer.clear()
    assert buffer.children == []
    with pytest.raises(UnconnectedFramesError):
        place(buffer, "root", "a")


def test_frames_and_their_names_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tf_buffer, "MAX_FRAMES", 3)
    monkeypatch.setattr(tf_cache, "MAX_TRANSFORMS", 2)
    buffer = TransformBuffer()
    for step in range(5):
        assert buffer.set_transform(at("root", "a", 100 + step / 10)) == ""
    cache = buffer.cache_of("a")
    assert cache is not None
    assert cache.oldest_ns == round(100.3 * SECOND)
    buffer.set_transform(at("root", "b", 100))
    assert "TF_TOO_MANY_FRAMES" in buffer.set_transform(at("root", "c", 100))
    assert "TF_LONG_FRAME_ID" in buffer.set_transform(at("root", "c" * 2000, 100))
    assert buffer.set_transform(at("root", "b", 101)) == ""


def test_invalid_numbers_are_refused() -> None:
    buffer = TransformBuffer()
    refused = StampedTransform("a", "b", 1, Transform((float("nan"), 0.0, 0.0)))
    assert buffer.set_transform(refused).startswith("TF_NAN_INPUT")
    refused = StampedTransform("a", "b", 1, Transform(rotation=(0.0, 0.0, float("inf"), 1.0)))
    assert buffer.set_transform(refused).startswith("TF_DENORMALIZED_QUATERNION")
    assert buffer.frames == []
