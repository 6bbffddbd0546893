from __future__ import annotations

import itertools

import pytest
from msgspec.structs import replace

from rostether.rosserial import negotiation as module
from rostether.rosserial import topic_id as ids
from rostether.rosserial.negotiation import (
    MAX_QUIET_S,
    MAX_ROUNDS,
    MAX_UNANSWERED,
    QUIET_MARGIN,
    QUIET_S,
    RETRY_S,
    TRANSITIONS,
    Negotiation,
    Phase,
)
from rostether.rosserial.packets import TopicInfo
from unit.rosserial.sessions import STRING, STRING_MD5
from unit.rosserial.state_tables import drawn_transitions

INFO = TopicInfo(125, "chatter", STRING, STRING_MD5, 280)


def test_the_table_is_the_one_that_is_drawn() -> None:
    drawn = {(state, what): following for state, what, following, _ in drawn_transitions(module)}
    assert drawn == {
        (state.name, what.name): following.name for (state, what), following in TRANSITIONS.items()
    }


def tick(negotiation: Negotiation) -> tuple[float, bool]:
    """Let the timer fire when it is due; return when that was, and whether it settled."""
    due_s = negotiation.get_timer()
    assert due_s is not None
    return due_s, negotiation.handle_timer(due_s, is_flowing=False)


def settled(version: int = 2) -> tuple[Negotiation, float]:
    """Return a negotiation that has settled on one publisher, and the time."""
    negotiation = Negotiation()
    negotiation.set_version(version, 0.0)
    negotiation.ask(0.0)
    now_s, done = 0.0, False
    while not done:
        if negotiation.pop_request() is not None:
            negotiation.time_requested(now_s + 0.01)
            negotiation.announced(ids.PUBLISHER, INFO, now_s + 0.02)
        now_s, done = tick(negotiation)
    return negotiation, now_s


def test_searching_alternates_versions_and_leaves_the_line_quiet_between() -> None:
    negotiation = Negotiation()
    negotiation.ask(0.0)
    asked = [(0.0, negotiation.pop_request())]
    while len(asked) < 12:
        now_s, _ = tick(negotiation)
        asked.append((now_s, negotiation.pop_request()))
    gaps = [later[0] - earlier[0] for earlier, later in itertools.pairwise(asked)]
    assert min(gaps) > 0.02
    assert asked[0][1] == 2
    assert {version for _, version in asked} == {1, 2}
    assert [version for _, version in asked[-4:]] in ([1, 2, 1, 2], [2, 1, 2, 1])
    for wanted in (1, 2):
        times = [now_s for now_s, version in asked if version == wanted]
        assert max(later - earlier for earlier, later in itertools.pairwise(times)) <= 1.0


def test_nothing_is_asked_while_the_burst_flows() -> None:
    negotiation = Negotiation()
    negotiation.set_version(2, 0.0)
    negotiation.ask(0.0)
    assert negotiation.pop_request() == 2
    for number in range(50):
        now_s = 0.01 + number * 0.06
        assert not negotiation.handle_timer(now_s, is_flowing=False)
        negotiation.announced(ids.PUBLISHER, TopicInfo(125 + number, "a", STRING, STRING_MD5, 280), now_s)
        assert negotiation.pop_request() is None
    assert negotiation.get_timer() == pytest.approx(0.01 + 49 * 0.06 + QUIET_S)


def test_an_announcement_that_is_just_coming_in_prolongs_the_burst() -> None:
    negotiation = Negotiation()
    negotiation.set_version(2, 0.0)
    negotiation.ask(0.0)
    negotiation.pop_request()
    negotiation.time_requested(0.01)
    assert not negotiation.handle_timer(0.2, is_flowing=True)
    assert negotiation.pop_request() is None
    assert negotiation.phase is Phase.LISTENING


def test_a_healthy_board_is_asked_twice_at_the_start_and_once_later() -> None:
    negotiation, now_s = settled()
    assert negotiation.requests == 2
    assert negotiation.round_trip_s == pytest.approx(0.01)
    negotiation.ask(now_s)
    assert negotiation.pop_request() == 2
    negotiation.announced(ids.PUBLISHER, INFO, now_s + 0.01)
    _, done = tick(negotiation)
    assert done
    assert negotiation.requests == 1


def test_unanswered_requests_are_repeated_less_and_less_often() -> None:
    negotiation = Negotiation()
    negotiation.set_version(2, 0.0)
    negotiation.ask(0.0)
    times = [0.0]
    for _ in range(8):
        now_s, _ = tick(negotiation)
        assert negotiation.pop_request() == 2
        times.append(now_s)
    gaps = [later - earlier for earlier, later in itertools.pairwise(times)]
    assert gaps == pytest.approx([0.2, 0.3, 0.45, 0.675, 1.0, 1.0, 1.0, 1.0])
    assert gaps[0] == RETRY_S


def test_a_slow_sketch_is_given_the_time_it_takes() -> None:
    negotiation = Negotiation()
    negotiation.set_version(2, 0.0)
    negotiation.ask(0.0)
    negotiation.pop_request()
    negotiation.time_requested(0.19)
    negotiation.announced(ids.PUBLISHER, INFO, 0.19)
    tick(negotiation)
    assert negotiation.pop_request() == 2
    due_s = negotiation.get_timer()
    assert due_s == pytest.approx(0.19 + QUIET_S + 1.5 * 0.19)


def test_a_device_that_answers_only_once_is_left_in_peace() -> None:
    negotiation = Negotiation()
    negotiation.set_version(2, 0.0)
    negotiation.ask(0.0)
    negotiation.pop_request()
    negotiation.announced(ids.PUBLISHER, INFO, 0.01)
    done, asked = False, 0
    while not done:
        now_s, done = tick(negotiation)
        asked += negotiation.pop_request() is not None
        assert now_s < 10
    assert asked == MAX_UNANSWERED
    assert len(negotiation.endpoints) == 1
    assert negotiation.get_timer() is None


def test_a_device_that_never_answers_is_asked_for_ever() -> None:
    negotiation = Negotiation()
    negotiation.set_version(2, 0.0)
    negotiation.ask(0.0)
    for _ in range(50):
        _, done = tick(negotiation)
        assert not done


def test_a_detected_version_is_used_for_a_request_immediately() -> None:
    negotiation = Negotiation()
    negotiation.ask(0.0)
    assert negotiation.pop_request() == 2
    negotiation.set_version(1, 0.1)
    assert negotiation.pop_request() == 1
    negotiation.set_version(1, 0.2)
    assert negotiation.pop_request() is None


def test_unrequested_announcements_with_news_are_confirmed() -> None:
    negotiation, now_s = settled()
    negotiation.announced(ids.PUBLISHER, TopicInfo(126, "other", STRING, STRING_MD5, 280), now_s + 5)
    now_s, done = tick(negotiation)
    assert not done
    while not done:
        assert negotiation.pop_request() == 2
        for topic_id in (125, 126):
            negotiation.announced(ids.PUBLISHER, replace(INFO, topic_id=topic_id), now_s + 0.01)
        now_s, done = tick(negotiation)
    assert negotiation.requests == 2
    assert len(negotiation.endpoints) == 2


def test_damage_on_a_clean_line_causes_one_request() -> None:
    negotiation, now_s = settled()
    negotiation.note_damage(now_s + 1)
    assert negotiation.pop_request() == 2
    negotiation.announced(ids.PUBLISHER, INFO, now_s + 1.01)
    _, done = tick(negotiation)
    assert done
    negotiation.note_damage(now_s + 9)
    assert negotiation.pop_request() is None
    assert negotiation.is_settled


def burst(count: int, first_s: float, pause_s: float) -> list[tuple[float, TopicInfo]]:
    """Return announcements this far apart, and when they come."""
    return [(first_s + number * pause_s, replace(INFO, topic_id=125 + number)) for number in range(count)]


def settle_against(pause_s: float, count: int = 4, limit_s: float = 60.0) -> tuple[Negotiation, float]:
    """Negotiate with a board that answers requests one after the other, pausing between announcements."""
    negotiation = Negotiation()
    negotiation.set_version(2, 0.0)
    negotiation.ask(0.0)
    negotiation.pop_request()
    coming: list[tuple[float, TopicInfo | None]] = [(0.01, None), *burst(count, 0.02, pause_s)]
    while not negotiation.is_settled:
        due_s = negotiation.get_timer()
        assert due_s is not None
        assert due_s < limit_s
        if coming and coming[0][0] <= due_s:
            now_s, info = coming.pop(0)
            if info is None:
                negotiation.time_requested(now_s)
            else:
                negotiation.announced(ids.PUBLISHER, info, now_s)
            continue
        now_s, _ = tick(negotiation)
        if negotiation.pop_request() is not None:
            free_s = max([now_s] + [at_s + pause_s for at_s, _ in coming[-1:]])
            coming += [(free_s + 0.01, None), *burst(count, free_s + 0.02, pause_s)]
    return negotiation, now_s


@pytest.mark.parametrize(
    ("pause_s", "max_requests"), [(0.05, 2), (0.09, 2), (0.15, 3), (0.19, 3), (0.3, 8), (0.6, 8), (1.2, 30)]
)
def test_pauses_between_announcements_are_learned(pause_s: float, max_requests: int) -> None:
    negotiation, _ = settle_against(pause_s)
    assert len(negotiation.endpoints) == 4
    assert negotiation.requests <= max_requests


def test_learned_pauses_serve_the_next_negotiation_and_are_forgotten_with_the_board() -> None:
    negotiation, now_s = settle_against(0.15)
    negotiation.ask(now_s)
    assert negotiation.pop_request() == 2
    for at_s, info in burst(4, now_s + 0.01, 0.15):
        assert not negotiation.handle_timer(at_s, is_flowing=False)
        negotiation.announced(ids.PUBLISHER, info, at_s)
    due_s, done = tick(negotiation)
    assert done
    assert negotiation.requests == 1
    assert due_s == pytest.approx(at_s + QUIET_MARGIN * 0.15)
    negotiation.set_version(None, due_s)
    negotiation.ask(due_s)
    negotiation.time_requested(due_s)
    assert negotiation.get_timer() == pytest.approx(due_s + QUIET_S)


def test_no_pause_is_waited_for_longer_than_the_bound() -> None:
    negotiation, _ = settle_against(0.95)
    assert negotiation.get_timer() is None
    negotiation.ask(100.0)
    negotiation.time_requested(100.0)
    assert negotiation.get_timer() == pytest.approx(100.0 + MAX_QUIET_S)


def test_a_board_that_announces_something_else_each_time_is_left_in_peace() -> None:
    negotiation = Negotiation()
    negotiation.set_version(2, 0.0)
    negotiation.ask(0.0)
    now_s, done = 0.0, False
    while not done:
        if negotiation.pop_request() is not None:
            negotiation.time_requested(now_s + 0.01)
            negotiation.announced(
                ids.PUBLISHER, replace(INFO, topic_name=f"t{negotiation.requests}"), now_s + 0.01
            )
        now_s, done = tick(negotiation)
    assert negotiation.requests == MAX_ROUNDS
    assert negotiation.get_timer() is None


def test_a_board_that_answers_without_announcing_any_more_is_left_in_peace() -> None:
    negotiation, now_s = settled()
    negotiation.ask(now_s)
    done = False
    while not done:
        if negotiation.pop_request() is not None:
            negotiation.time_requested(now_s + 0.01)
        now_s, done = tick(negotiation)
    assert negotiation.requests <= MAX_ROUNDS
    assert len(negotiation.endpoints) == 1


def test_an_announcement_before_the_first_request_changes_nothing() -> None:
    negotiation = Negotiation()
    negotiation.announced(ids.PUBLISHER, INFO, 0.0)
    assert negotiation.phase is Phase.IDLE
    assert negotiation.get_timer() is None
