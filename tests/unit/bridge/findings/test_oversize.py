from __future__ import annotations

from rostether.bridge.findings.oversize import RECENT_S, REST_GAP_S, Oversizes
from rostether.rosserial.events import DiscardReason, FrameDiscarded
from rostether.rosserial.frame import encode_frame

FRAME = encode_frame(125, b"x" * 300)


def head(size: int = 50) -> FrameDiscarded:
    return FrameDiscarded(DiscardReason.TOO_LONG, FRAME[:size])


def noise(data: bytes) -> FrameDiscarded:
    return FrameDiscarded(DiscardReason.NOISE, data)


def test_the_third_case_is_reported() -> None:
    oversizes = Oversizes()
    for number in range(3):
        assert oversizes.of(125, number) is None
        assert oversizes.handle_discarded(head(), 2, number)
    found = oversizes.of(125, 3.0)
    assert found is not None
    assert (found.count, found.largest_bytes) == (3, 300)
    assert oversizes.of(126, 3.0) is None
    assert oversizes.of(125, 3.0 + RECENT_S) is None


def test_once_in_a_while_is_damage() -> None:
    oversizes = Oversizes()
    for number in range(20):
        oversizes.handle_discarded(head(), 2, number * (RECENT_S + 1))
        assert oversizes.of(125, number * (RECENT_S + 1)) is None


def test_following_bytes_are_the_rest_of_the_message() -> None:
    oversizes = Oversizes()
    assert not oversizes.handle_discarded(noise(b"hello"), 2, 0.0)
    oversizes.handle_discarded(head(50), 2, 0.0)
    assert oversizes.handle_discarded(noise(FRAME[50:200]), 2, 0.05)
    assert oversizes.handle_discarded(noise(FRAME[200:]), 2, 0.1)
    assert not oversizes.handle_discarded(noise(b"hello"), 2, 0.1)


def test_bytes_that_arrive_much_later_are_not_the_rest() -> None:
    oversizes = Oversizes()
    oversizes.handle_discarded(head(50), 2, 0.0)
    assert not oversizes.handle_discarded(noise(b"hello"), 2, REST_GAP_S * 1.1)


def test_a_header_that_seems_to_contain_another() -> None:
    """511 is ff 01: the length could be the beginning of a frame."""
    frame = encode_frame(125, b"x" * 511)
    oversizes = Oversizes()
    for number in range(3):
        oversizes.handle_discarded(FrameDiscarded(DiscardReason.TOO_LONG, frame[:2]), 2, number)
        assert oversizes.handle_discarded(FrameDiscarded(DiscardReason.VERSION, frame[2:]), 2, number)
    found = oversizes.of(125, 3.0)
    assert found is not None
    assert found.largest_bytes == 511


def test_many_ids_do_not_fill_the_memory() -> None:
    oversizes = Oversizes()
    for topic_id in range(100, 1100):
        oversizes.handle_discarded(
            FrameDiscarded(DiscardReason.TOO_LONG, encode_frame(topic_id, b"x")), 2, 0.0
        )
    assert len(oversizes._found) <= 64
