from __future__ import annotations

import pytest

from rostether.conformance.case import Verdict
from rostether.conformance.run_cases import CASES
from unit.bridge.virtual_time import on_virtual_time, run
from unit.conformance.clients import outcomes
from unit.conformance.faults import FAULTS, Fault


@on_virtual_time
async def test_the_python_device_passes_every_case() -> None:
    found = await outcomes()
    assert [(each.case.name, each.seen) for each in found if each.verdict is not Verdict.PASS] == []
    assert len(found) == len(CASES) >= 40


@pytest.mark.parametrize("fault", FAULTS, ids=lambda each: each.name)
def test_each_planted_fault_is_found(fault: Fault) -> None:
    found = {each.case.name: each for each in run(outcomes(fault.plant))}
    assert found[fault.found_by].verdict is Verdict.FAIL
    print(fault.name, [n for n, o in found.items() if o.verdict is Verdict.FAIL], found[fault.found_by].seen)


def test_a_client_that_answers_only_the_first_request_is_checked_on_new_lines() -> None:
    fault = next(each for each in FAULTS if each.name == "only the first request answered")
    found = run(outcomes(fault.plant))
    # Cases that need no second request.
    assert len([each for each in found if each.verdict is Verdict.PASS]) > len(CASES) // 2
