from __future__ import annotations

from rostether.bridge.findings.damage import WINDOW_S, Damage
from rostether.bridge.findings.finding import Code
from rostether.rosserial.events import DiscardReason, FrameDiscarded

CHECKSUM = FrameDiscarded(DiscardReason.PAYLOAD_CHECKSUM, b"\xff\xfe\x05\x00\xfa")
REST = FrameDiscarded(DiscardReason.NOISE, b"the rest of it")


def test_the_share_is_reported() -> None:
    damage = Damage()
    assert damage.find(0, 0.0) is None
    for number in range(10):
        damage.count_discarded(CHECKSUM, number / 10, 0)
    finding = damage.find(490, 1.0)
    assert finding is not None
    assert finding.code is Code.FRAMES_DAMAGED
    assert finding.seen.startswith("2 % of the frames are damaged (10 of the last 500)")


def test_the_rest_of_a_damaged_frame_is_not_a_second_one() -> None:
    damage = Damage()
    damage.find(0, 0.0)
    for number in range(5):
        damage.count_discarded(CHECKSUM, float(number), 0)
        damage.count_discarded(REST, float(number), 0)
    finding = damage.find(5, 5.0)
    assert finding is not None
    assert "(5 of the last 10" in finding.seen


def test_the_rest_of_a_long_frame_in_pieces_is_one_damaged_frame() -> None:
    damage = Damage()
    damage.find(0, 0.0)
    # The port was opened in the middle of a message of 720 bytes.
    for number in range(40):
        damage.count_discarded(REST, number / 100, 1)
    assert damage.find(60, 1.0) is None
    for number in range(1, 3):
        damage.count_discarded(REST, float(number), 60 + number)
    finding = damage.find(90, 4.0)
    assert finding is not None
    assert "(3 of the last 93" in finding.seen


def test_a_frame_whose_first_byte_was_damaged_counts() -> None:
    damage = Damage()
    damage.find(0, 0.0)
    for number in range(1, 5):
        damage.count_discarded(REST, float(number), 0)
    finding = damage.find(4, 5.0)
    assert finding is not None
    assert "(4 of the last 8" in finding.seen


def test_one_damaged_frame_is_nothing() -> None:
    damage = Damage()
    damage.find(0, 0.0)
    damage.count_discarded(CHECKSUM, 0.5, 0)
    assert damage.find(10, 1.0) is None


def test_damage_without_a_valid_frame_after_it_is_not_the_lines_fault() -> None:
    damage = Damage()
    damage.find(100, 0.0)
    for number in range(20):
        damage.count_discarded(CHECKSUM, number / 10, 110)
        assert damage.find(110, number / 10) is None
    assert damage.find(111, 3.0) is not None


def test_a_repaired_problem_is_forgotten_after_a_while() -> None:
    damage = Damage()
    damage.find(0, 0.0)
    for number in range(10):
        damage.count_discarded(CHECKSUM, number / 10, 0)
    assert damage.find(100, 1.0) is not None
    for second in range(2, int(3 * WINDOW_S)):
        finding = damage.find(100 * second, float(second))
    assert finding is None


def test_frames_that_resets_cut_are_not_damage() -> None:
    damage = Damage()
    damage.find(0, 0.0)
    for number in range(6):
        damage.count_discarded(CHECKSUM, number / 10, 0)
    assert damage.find(100, 1.0, 3) is None
    assert damage.find(100, 1.0, 1) is not None
