from __future__ import annotations

from rostether.bridge.findings.finding import Code, Finding, error, warning
from rostether.bridge.findings.ledger import FORGET_AFTER_S, MAX_KEYS, FindingLedger


def slow(late_ms: int = 100) -> Finding:
    return warning(Code.SLOW_LOOP, f"late by {late_ms} ms", "spin more often")


def test_a_finding_is_reported_once_while_it_stands() -> None:
    ledger = FindingLedger()
    assert ledger.news([slow()], 0.0) == [slow()]
    for second in range(1, 600):
        assert ledger.news([slow(second)], float(second)) == []


def test_it_is_reported_again_when_it_comes_back_after_a_minute() -> None:
    ledger = FindingLedger()
    ledger.news([slow()], 0.0)
    assert ledger.news([slow()], FORGET_AFTER_S - 1) == []
    assert ledger.news([slow()], 2 * FORGET_AFTER_S) == [slow()]


def test_it_is_reported_again_when_it_gets_worse() -> None:
    ledger = FindingLedger()
    worse = error(Code.SLOW_LOOP, "late by 9 s", "spin more often")
    ledger.news([slow()], 0.0)
    assert ledger.news([worse], 1.0) == [worse]


def test_findings_of_several_subjects_are_all_reported() -> None:
    ledger = FindingLedger()
    both = [error(Code.BUFFER_TOO_SMALL, topic, "", topic) for topic in ("a", "b")]
    assert ledger.news(both[:1], 0.0) == both[:1]
    assert ledger.news(both, 1.0) == both[1:]


def test_a_board_that_makes_up_names_fills_no_memory() -> None:
    ledger = FindingLedger()
    for number in range(2 * MAX_KEYS):
        ledger.news([error(Code.NOT_BRIDGED, "", "", str(number))], 0.0)
    assert len(ledger._reported) == MAX_KEYS


def test_what_was_gone_for_certain_is_news_again() -> None:
    ledger = FindingLedger()
    ledger.news([slow()], 0.0)
    ledger.forget(Code.SLOW_LOOP)
    assert ledger.news([slow()], 1.0) == [slow()]
