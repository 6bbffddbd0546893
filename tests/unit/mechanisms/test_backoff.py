from __future__ import annotations

import asyncio

import pytest

from rostether.errors import GraphError, MasterUnreachableError
from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.waiting import wait_for_master


def test_double_up_to_the_limit() -> None:
    backoff = Backoff(first_s=0.1, limit_s=1.0, jitter=0.0)
    assert [backoff.next_delay_s() for _ in range(6)] == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.0, 1.0])


def test_begin_again_after_success() -> None:
    backoff = Backoff(first_s=0.1, jitter=0.0)
    backoff.next_delay_s()
    backoff.next_delay_s()
    backoff.reset()
    assert backoff.next_delay_s() == pytest.approx(0.1)


def test_jitter_only_shortens() -> None:
    backoff = Backoff(first_s=1.0, limit_s=1.0, jitter=0.5)
    delays = [backoff.next_delay_s() for _ in range(50)]
    assert all(0.5 <= delay <= 1.0 for delay in delays)
    assert len(set(delays)) > 40


def test_two_backoffs_have_different_delays() -> None:
    assert (
        Backoff(first_s=1.0, limit_s=9.0).next_delay_s() != Backoff(first_s=1.0, limit_s=9.0).next_delay_s()
    )


async def test_attempts_are_repeated_and_only_the_first_failure_is_reported() -> None:
    attempts, reports = [0], list[str]()

    async def join() -> str:
        attempts[0] += 1
        if attempts[0] < 4:
            raise MasterUnreachableError(f"attempt {attempts[0]}")
        return "graph"

    async with asyncio.timeout(60):
        graph = await wait_for_master(join, lambda error: reports.append(str(error)), max_retry_s=0.001)
    assert graph == "graph"
    assert (attempts, reports) == ([4], ["attempt 1"])


async def test_nothing_is_reported_where_the_master_answers() -> None:
    async def join() -> str:
        return "graph"

    assert await wait_for_master(join, lambda error: pytest.fail(str(error))) == "graph"


async def test_other_errors_pass() -> None:
    async def join() -> str:
        raise GraphError("another node has the name")

    with pytest.raises(GraphError, match="another node"):
        await wait_for_master(join, lambda error: pytest.fail(str(error)))
