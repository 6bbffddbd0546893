from __future__ import annotations

from rostether.rosserial.topic_answers import LATE_ANSWER_S, OPENING_S, TimeRequestMeaning, TopicAnswers
from rostether.rosserial.topic_table import EndpointKey

ONE = EndpointKey(sends=True, topic_id=125)
OTHER = EndpointKey(sends=False, topic_id=100)


def take_time(answers: TopicAnswers, now_s: float) -> TimeRequestMeaning:
    return answers.time_requested(now_s, has_topics=True)


def take_topics(answers: TopicAnswers, now_s: float, *, is_known: bool = True) -> None:
    for key in (ONE, OTHER):
        answers.announced(key, now_s, is_known=is_known)


def asked(count: int) -> TopicAnswers:
    answers = TopicAnswers()
    for _ in range(count):
        answers.requested(0.0)
    return answers


def test_each_request_has_one_answer() -> None:
    answers = asked(3)
    for now_s in (1.0, 2.0, 6.0):
        assert take_time(answers, now_s) is TimeRequestMeaning.ANSWER
        take_topics(answers, now_s)
    assert answers.waiting(6.0) == 0
    assert take_time(answers, 7.0) is TimeRequestMeaning.ALONE


def test_a_request_without_an_answer_for_long_is_lost() -> None:
    answers = asked(3)
    assert take_time(answers, LATE_ANSWER_S + 0.1) is TimeRequestMeaning.ALONE


def test_time_requests_without_topics_are_not_answers() -> None:
    answers = asked(5)
    assert take_time(answers, 1.0) is TimeRequestMeaning.ANSWER
    assert take_time(answers, 1.4) is TimeRequestMeaning.ALONE


def test_a_board_without_topics_answers_with_time_requests() -> None:
    answers = asked(2)
    for now_s in (1.0, 1.4):
        assert answers.time_requested(now_s, has_topics=False) is TimeRequestMeaning.ANSWER


def test_known_topics_before_the_time_request_are_an_introduction_even_if_requests_wait() -> None:
    answers = asked(3)
    take_topics(answers, 1.0)
    assert take_time(answers, 1.01) is TimeRequestMeaning.INTRODUCTION
    assert answers.waiting(1.01) == 3


def test_a_new_board_introduces_itself_without_having_been_reset() -> None:
    answers = asked(1)
    take_topics(answers, 1.0, is_known=False)
    assert take_time(answers, 1.01) is TimeRequestMeaning.ALONE


def test_an_introduction_right_behind_an_answer() -> None:
    answers = asked(2)
    take_time(answers, 1.0)
    take_topics(answers, 1.0)
    take_topics(answers, 1.3)
    assert take_time(answers, 1.3) is TimeRequestMeaning.INTRODUCTION


def test_an_introduction_behind_a_time_request_that_was_due() -> None:
    answers = asked(2)
    take_time(answers, 1.0)
    take_topics(answers, 1.1 + OPENING_S)
    assert take_time(answers, 1.1 + OPENING_S) is TimeRequestMeaning.INTRODUCTION


def test_after_a_reset_no_answer_is_expected() -> None:
    answers = asked(3)
    answers.forget()
    assert take_time(answers, 1.0) is TimeRequestMeaning.ALONE


def test_an_answer_whose_time_request_was_damaged_is_not_an_introduction() -> None:
    answers = TopicAnswers()
    answers.damaged(1.0)
    take_topics(answers, 1.05)
    assert take_time(answers, 1.1) is TimeRequestMeaning.ALONE
    take_topics(answers, 3.0)
    assert take_time(answers, 3.1) is TimeRequestMeaning.INTRODUCTION


def test_time_requests_for_unknown_bytes_are_one_answer_at_most() -> None:
    answers = asked(3)
    for now_s in (1.0, 1.003, 1.006):
        assert answers.time_requested(now_s, has_topics=False) is TimeRequestMeaning.ANSWER
    assert answers.waiting(1.006) == 2
