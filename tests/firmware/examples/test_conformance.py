"""The C++ client on simulated boards passes the conformance kit, at the speed of real boards."""

from __future__ import annotations

import pytest

from effort import effort
from firmware.examples.stage import running_alone
from rostether.conformance.case import Verdict
from rostether.conformance.checked_client import CheckedClient
from rostether.conformance.run_cases import CASES, run_cases
from rostether.transports.opening import open_transport


@pytest.mark.parametrize("board_kind", ["uno", "leonardo"])
async def test_the_library_passes_the_cases(board_kind: str) -> None:
    async with running_alone("Conformance", board_kind) as board:
        client = CheckedClient(lambda: open_transport(board.address))
        try:
            await client.open()
            # The case of a lost host waits 14 s.
            longest_s = effort(10, 60)
            cases = [each for each in CASES if each.wait_s < longest_s]
            found = [each async for each in run_cases(client, cases)]
            # On a busy machine, a pause inside a frame may be longer than the client waits for the rest.
            failed = [each.case for each in found if each.verdict is not Verdict.PASS]
            again = [each async for each in run_cases(client, failed)]
        finally:
            await client.close()
    assert [(each.case.name, each.seen) for each in again if each.verdict is not Verdict.PASS] == []
    assert len(found) >= 40
