from __future__ import annotations

import asyncio

import pytest

from rostether.errors import GraphError, MasterUnreachableError
from rostether.mechanisms.waiting import wait_for_master


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
