from __future__ import annotations

from rostether.bridge.findings.finding import Code
from rostether.bridge.findings.resets import WINDOW_S, Resets


def test_three_in_a_minute_are_a_loop() -> None:
    resets = Resets()
    for second in (0.0, 10.0):
        resets.record(second)
    assert resets.find(20.0, None) is None
    resets.record(20.0)
    finding = resets.find(20.0, None)
    assert finding is not None
    assert finding.code is Code.RESET_LOOP
    assert "3 times in 20 s" in finding.seen


def test_a_port_that_disappears_may_be_a_loose_plug() -> None:
    resets = Resets()
    for second in range(3):
        resets.record(float(second), was_gone=second == 1)
    finding = resets.find(3.0, None)
    assert finding is not None
    assert finding.seen == "the board was reset or unplugged 3 times in 3 s"
    assert finding.next_step.startswith("check the plug and the cable, power motors")
    for second in range(3):
        resets.record(WINDOW_S + 10.0 + second)
    finding = resets.find(WINDOW_S + 13.0, None)
    assert finding is not None
    assert finding.seen.startswith("the board was reset 3 times")


def test_output_of_the_board_is_reported() -> None:
    resets = Resets()
    for second in range(3):
        resets.record(float(second))
    finding = resets.find(3.0, "Brownout detector was triggered")
    assert finding is not None
    assert "Brownout detector" in finding.seen


def test_the_reset_button_pressed_sometimes_is_not_a_reset_loop() -> None:
    resets = Resets()
    for number in range(20):
        resets.record(number * WINDOW_S / 2.2)
        assert resets.find(number * WINDOW_S / 2.2, None) is None or number >= 2
    assert resets.find(1e6, None) is None
