"""Cycles that the client library needs on an AVR; they are the same in each simulated run."""

from __future__ import annotations

import pytest

from firmware.examples import counting
from firmware.examples.established import has_measured_compiler

# avr-gcc 14 and 16 need up to 27 % more cycles than avr-gcc 5.4.
SLACK_OF_NEWER_COMPILERS = 1.3


async def test_no_operation_needs_more_cycles_than_its_limit(capsys: pytest.CaptureFixture[str]) -> None:
    cycles = await counting.count_async(neutral=True)
    with capsys.disabled():
        print("\n" + "\n".join(f"{each.name:<40}{cycles[each]:>7}{each.max_cycles:>7}" for each in cycles))
    slack = 1 if has_measured_compiler() else SLACK_OF_NEWER_COMPILERS
    assert {each.name: cycles[each] for each in cycles if cycles[each] > each.max_cycles * slack} == {}


@pytest.mark.parametrize("operation", counting.OPERATIONS, ids=lambda each: each.name)
def test_no_limit_is_above_the_established_library(operation: counting.Operation) -> None:
    if operation.established is not None:
        assert operation.max_cycles <= operation.established * operation.max_part
