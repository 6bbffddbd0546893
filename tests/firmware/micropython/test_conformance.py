"""The client library on MicroPython passes the conformance kit."""

from __future__ import annotations

from pathlib import Path

from firmware.micropython.boards import EXAMPLES, usb_board
from rostether.conformance.case import Verdict
from rostether.conformance.checked_client import CheckedClient
from rostether.conformance.run_cases import CASES, run_cases
from rostether.transports.opening import open_transport


async def test_the_library_passes_the_cases(library: Path) -> None:
    async with usb_board(EXAMPLES / "conformance.py", library) as board:
        client = CheckedClient(lambda: open_transport(board.address))
        try:
            await client.open()
            # The case of a lost host waits 14 s.
            cases = [each for each in CASES if each.wait_s < 10]
            found = [each async for each in run_cases(client, cases)]
            # On a busy machine, a pause inside a frame may be longer than the client waits for the rest.
            failed = [each.case for each in found if each.verdict is not Verdict.PASS]
            again = [each async for each in run_cases(client, failed)]
        finally:
            await client.close()
    assert [(each.case.name, each.seen) for each in again if each.verdict is not Verdict.PASS] == []
    assert len(found) >= 40
