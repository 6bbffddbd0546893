from __future__ import annotations

import pytest

from rostether.rosserial import presence as module
from rostether.rosserial.presence import (
    EARLY_S,
    LATE_S,
    NEXT_PROBE_S,
    OVERDUE_S,
    PROBE_AFTER_S,
    SILENT_AFTER_S,
    TRANSITIONS,
    Presence,
    State,
    Verdict,
)
from unit.rosserial.state_tables import drawn_transitions


def test_the_table_is_the_one_that_is_drawn() -> None:
    drawn = {}
    for state, what, following, verdict in drawn_transitions(module):
        drawn[state, what] = following, verdict if verdict in Verdict.__members__ else ""
    assert drawn == {
        (state.name, what.name): (following.name, verdict.name if verdict else "")
        for (state, what), (following, verdict) in TRANSITIONS.items()
    }


def present(now_s: float = 0.0) -> Presence:
    presence = Presence()
    presence.answer_received(now_s)
    assert presence.state is State.PRESENT
    return presence


def test_nothing_is_due_before_the_first_data_of_the_device() -> None:
    assert Presence().get_timer(probes=True) is None
    assert Presence().handle_timer(100.0, probes=True) is None


def test_a_board_that_publishes_is_not_probed() -> None:
    presence = present()
    for tenth in range(1, 100):
        presence.message_received(tenth / 10)
        assert presence.handle_timer(tenth / 10, probes=True) is None


def test_silence_leads_to_probes() -> None:
    presence = present()
    probes: list[float] = []
    while len(probes) < 4:
        due_s = presence.get_timer(probes=True)
        assert due_s is not None
        assert presence.handle_timer(due_s, probes=True) is Verdict.PROBE
        probes.append(due_s)
    assert probes == pytest.approx([PROBE_AFTER_S + NEXT_PROBE_S * number for number in range(4)])


def test_an_answer_to_the_probe_means_reset() -> None:
    presence = present()
    presence.message_received(1.5)
    assert presence.handle_timer(2.5, probes=True) is Verdict.PROBE
    assert presence.time_request_received(2.51) is Verdict.PROBE  # or was it just due?
    assert presence.time_request_received(2.52) is Verdict.RESET


def test_a_much_too_early_answer_shows_a_reset_immediately() -> None:
    presence = present()
    assert presence.handle_timer(PROBE_AFTER_S, probes=True) is Verdict.PROBE
    assert presence.time_request_received(PROBE_AFTER_S + 0.01) is Verdict.RESET


def test_a_healthy_silent_board_is_never_taken_for_reset() -> None:
    presence = present()
    now_s, next_request_s = 0.0, 2.5
    while now_s < 100:
        due_s = presence.get_timer(probes=True)
        assert due_s is not None
        now_s = min(due_s, next_request_s)
        if now_s == next_request_s:
            assert presence.time_request_received(now_s) is not Verdict.RESET
            next_request_s += 2.5
        else:
            assert presence.handle_timer(now_s, probes=True) in (None, Verdict.PROBE)


def test_the_answer_to_a_second_probe_may_be_lost() -> None:
    presence = present()
    assert presence.handle_timer(2.0, probes=True) is Verdict.PROBE
    assert presence.time_request_received(2.5) is Verdict.PROBE
    assert presence.handle_timer(2.5 + NEXT_PROBE_S, probes=True) is Verdict.PROBE
    assert presence.time_request_received(2.51 + NEXT_PROBE_S) is Verdict.RESET


def test_an_early_time_request_is_only_probed() -> None:
    presence = present()
    assert presence.time_request_received(EARLY_S - 0.1) is Verdict.PROBE
    presence.message_received(EARLY_S)
    assert presence.state is State.PRESENT


def test_announcements_do_not_move_the_time_request_that_is_due() -> None:
    presence = present()
    presence.sign_received(1.0)
    assert presence.time_request_received(2.5) is None


def test_a_time_request_that_waited_behind_others_makes_the_next_one_not_early() -> None:
    presence = present()
    presence.answer_received(3.3, is_timely=False)
    assert presence.time_request_received(5.0) is None


def test_an_overdue_time_request_is_asked_for_once() -> None:
    presence = present()
    assert presence.handle_timer(OVERDUE_S, probes=True) is Verdict.ASK
    assert presence.get_timer(probes=True) == SILENT_AFTER_S
    assert presence.handle_timer(OVERDUE_S + 0.5, probes=True) is None
    presence.answer_received(OVERDUE_S + 0.6)
    assert presence.state is State.PRESENT


def test_silence_is_reported_once() -> None:
    presence = present()
    assert presence.get_timer(probes=False) == SILENT_AFTER_S
    assert presence.handle_timer(SILENT_AFTER_S - 0.1, probes=False) is None
    assert presence.handle_timer(SILENT_AFTER_S, probes=False) is Verdict.SILENT
    assert presence.handle_timer(SILENT_AFTER_S + 9, probes=False) is None
    presence.time_request_received(20.0)
    assert presence.state is State.PRESENT


def test_resets_of_a_device_that_answers_every_probe_are_detected_less_and_less_often() -> None:
    presence = present()
    now_s, resets = 0.0, []
    while now_s < 300:
        due_s = presence.get_timer(probes=True)
        assert due_s is not None
        now_s = due_s
        verdict = presence.handle_timer(now_s, probes=True)
        while verdict is Verdict.PROBE:
            now_s += 0.01
            verdict = presence.time_request_received(now_s)
        if verdict is Verdict.RESET:
            resets.append(now_s)
            presence.answer_received(now_s)
    assert len(resets) < 20
    assert resets[-1] - resets[-2] > 50


def test_a_stall_of_this_process_is_not_a_reset_of_the_board() -> None:
    presence = present()
    presence.time_request_received(2.5)
    verdicts = []
    resumed_s = 5.0 + 0.7
    assert (due_s := presence.get_timer(probes=True)) is not None
    assert resumed_s > due_s + LATE_S
    for now_s in (resumed_s, 7.5):
        presence.frame_received(now_s)
        verdicts.append(presence.time_request_received(now_s))
        if (due_s := presence.get_timer(probes=True)) is not None:
            verdicts.append(presence.handle_timer(due_s, probes=True))
    assert Verdict.RESET not in verdicts


def test_a_pause_of_this_process_is_not_silence_of_the_board() -> None:
    presence = present()
    due_s = presence.get_timer(probes=True)
    assert due_s is not None
    presence.message_received(due_s - 0.1)
    assert presence.handle_timer(due_s + 12.0, probes=True) is None
    assert presence.is_certain
    assert presence.get_timer(probes=True) == due_s + 12.0 + PROBE_AFTER_S
    assert presence.handle_timer(due_s + 12.0 + PROBE_AFTER_S, probes=True) is Verdict.PROBE


def test_a_reset_after_a_stall_is_found() -> None:
    presence = present()
    presence.time_request_received(2.5)
    now_s, verdicts = 6.0, [Verdict.PROBE]
    while Verdict.RESET not in verdicts and now_s < 12.0:
        # A board that was reset answers each probe.
        presence.frame_received(now_s)
        if (verdict := presence.time_request_received(now_s)) is not None:
            verdicts.append(verdict)
        due_s = presence.get_timer(probes=True)
        assert due_s is not None
        presence.handle_timer(due_s, probes=True)
        now_s = due_s + 0.05
    assert Verdict.RESET in verdicts
    assert now_s < 6.0 + EARLY_S + 2 * NEXT_PROBE_S
