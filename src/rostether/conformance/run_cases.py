"""Runs the cases against one client, in the order of the specification."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence

from rostether.conformance.case import Case, CaseList, Outcome, Verdict
from rostether.conformance.cases import announcements, exchanges, frames, session
from rostether.conformance.checked_client import CheckedClient
from rostether.conformance.program import PREFIX
from rostether.conformance.received_frame import Deviation

case = CaseList()


@case("frame-sent")
async def check_sent(client: CheckedClient) -> None:
    """All bytes from the client are valid frames."""
    if client.damage:
        raise Deviation(f"{len(client.damage)} invalid frames or stray bytes, first {client.damage[0]}")


CASES: tuple[Case, ...] = (
    *announcements.case.cases,
    *frames.case.cases,
    *exchanges.case.cases,
    *session.case.cases,
    *case.cases,
)


async def run_cases(client: CheckedClient, cases: Sequence[Case] = CASES) -> AsyncIterator[Outcome]:
    """Check an open client, and yield the outcome of each case.

    Raises TransportError if the connection ends and cannot be opened again.
    """
    for each in cases:
        missing = [part for part in each.needs if not client.has(part)]
        if missing:
            names = ", ".join(PREFIX + role.name for part in missing for role in part.value)
            yield Outcome(each, Verdict.NOT_APPLICABLE, f"needs {names}")
            continue
        yield await _judge(client, each)


async def _judge(client: CheckedClient, case: Case) -> Outcome:
    try:
        await client.prepare()
        await case.check(client)
    except Deviation as deviation:
        # The client may be in any state now.
        client.require_configuration()
        return Outcome(case, Verdict.FAIL, str(deviation))
    return Outcome(case, Verdict.PASS)
