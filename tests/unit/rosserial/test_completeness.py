from __future__ import annotations

from rostether.rosserial import topic_id as ids
from rostether.rosserial.completeness import (
    EMPTY_CONFIRMATIONS,
    EQUAL_ROUNDS,
    LOSSY_CONFIRMATIONS,
    MAX_ANNOUNCED,
    Completeness,
)
from rostether.rosserial.packets import TopicInfo
from rostether.rosserial.topic_table import EndpointKey
from unit.rosserial.sessions import STRING, STRING_MD5

Announced = tuple[int, TopicInfo]


def publisher(topic_id: int, name: str = "") -> Announced:
    return ids.PUBLISHER, TopicInfo(topic_id, name or f"p{topic_id}", STRING, STRING_MD5, 280)


def half(kind: int, topic_id: int, name: str) -> Announced:
    return kind, TopicInfo(topic_id, name, STRING, STRING_MD5, 280)


def play(completeness: Completeness, *rounds: list[Announced]) -> list[bool]:
    verdicts = []
    for announcements in rounds:
        completeness.open_round()
        for kind, info in announcements:
            completeness.note_announcement(kind, info)
        verdicts.append(completeness.close_round())
    return verdicts


ONE, TWO, THREE = publisher(125), publisher(126), publisher(127)


def test_a_clean_line_needs_one_confirmation() -> None:
    assert play(Completeness(), [ONE, TWO], [ONE, TWO]) == [False, True]


def test_news_must_be_confirmed_again() -> None:
    verdicts = play(Completeness(), [ONE], [ONE, TWO], [ONE, TWO])
    assert verdicts == [False, False, True]


def test_rounds_that_differ_need_more() -> None:
    rounds = [[ONE], [TWO]] + [[ONE, TWO]] * LOSSY_CONFIRMATIONS
    assert play(Completeness(), *rounds) == [False] * (len(rounds) - 1) + [True]


def test_a_gap_in_the_ids_needs_more() -> None:
    assert play(Completeness(), *[[ONE, THREE]] * 4) == [False, False, False, True]


def test_half_a_service_needs_more() -> None:
    response = half(ids.SERVICE_SERVER_RESPONSE, 125, "ask")
    request = half(ids.SERVICE_SERVER_REQUEST, 100, "ask")
    assert play(Completeness(), *[[response]] * 4) == [False, False, False, True]
    assert play(Completeness(), *[[response, request]] * 2) == [False, True]


def test_damage_needs_more() -> None:
    completeness = Completeness()
    completeness.is_lossy = True
    assert play(completeness, *[[ONE]] * 4) == [False, False, False, True]


def test_an_empty_round_confirms_nothing() -> None:
    assert play(Completeness(), [ONE], [], [ONE]) == [False, False, False]


def test_a_device_without_endpoints() -> None:
    assert play(Completeness(), *[[]] * (1 + EMPTY_CONFIRMATIONS)) == [False, False, True]


def test_a_known_complete_state_needs_no_confirmation() -> None:
    completeness = Completeness()
    play(completeness, [ONE, TWO], [ONE, TWO])
    completeness.accept(is_confirmed=True)
    completeness.begin(is_lossy=False)
    assert play(completeness, [ONE, TWO]) == [True]


def test_half_a_service_that_was_complete_before_needs_no_confirmation() -> None:
    completeness = Completeness()
    response = half(ids.SERVICE_SERVER_RESPONSE, 125, "ask")
    play(completeness, *[[response]] * 4)
    completeness.accept(is_confirmed=True)
    completeness.begin(is_lossy=False)
    assert play(completeness, [response]) == [True]


def test_a_round_that_was_closed_too_early_continues() -> None:
    completeness = Completeness()
    assert play(completeness, [ONE]) == [False]
    assert completeness.is_continued_by(*TWO)
    assert not completeness.is_continued_by(*ONE)
    completeness.resume_round()
    completeness.note_announcement(*TWO)
    assert not completeness.close_round()
    assert completeness.rounds == 1
    assert play(completeness, [ONE, TWO]) == [True]


def test_nothing_continues_a_negotiation_that_has_begun_again() -> None:
    completeness = Completeness()
    play(completeness, [ONE])
    completeness.begin(is_lossy=False)
    assert not completeness.is_continued_by(*TWO)


def test_invented_ids_do_not_fill_the_memory() -> None:
    completeness = Completeness()
    play(completeness, [publisher(100 + number) for number in range(MAX_ANNOUNCED + 9)])
    completeness.accept(is_confirmed=True)
    assert len(completeness.endpoints) == MAX_ANNOUNCED


def test_less_than_before_needs_more() -> None:
    completeness = Completeness()
    play(completeness, [ONE, TWO], [ONE, TWO])
    completeness.accept(is_confirmed=True)
    completeness.begin(is_lossy=False)
    assert play(completeness, *[[ONE]] * 4) == [False, False, False, True]
    completeness.accept(is_confirmed=True)
    assert completeness.endpoints == {EndpointKey(True, 125)}


def test_unconfirmed_rounds_remove_nothing() -> None:
    completeness = Completeness()
    play(completeness, [ONE, TWO], [ONE, TWO])
    completeness.accept(is_confirmed=True)
    completeness.begin(is_lossy=False)
    play(completeness, [TWO, THREE])
    completeness.accept(is_confirmed=False)
    assert len(completeness.endpoints) == 3


def test_a_changed_announcement_is_news() -> None:
    assert play(Completeness(), [ONE], [publisher(125, "other")], [publisher(125, "other")]) == [
        False,
        False,
        True,
    ]


def test_endpoints_missing_in_equal_rounds_are_removed() -> None:
    completeness = Completeness()
    rounds = [[ONE, TWO, THREE], *[[ONE, TWO]] * EQUAL_ROUNDS]
    assert play(completeness, *rounds) == [False] * EQUAL_ROUNDS + [True]
    completeness.accept(is_confirmed=True)
    assert {key.topic_id for key in completeness.endpoints} == {125, 126}


def test_endpoints_missing_in_rounds_of_a_lossy_line_are_kept() -> None:
    completeness = Completeness()
    rounds = [[ONE, TWO, THREE], [ONE, TWO], [ONE], [ONE, TWO]]
    assert play(completeness, *rounds) == [False, False, False, True]
    completeness.accept(is_confirmed=True)
    assert len(completeness.endpoints) == 3
