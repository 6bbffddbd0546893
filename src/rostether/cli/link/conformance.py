"""`rostether conformance`: checks a client of the rosserial protocol case by case."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import click

from rostether.bridge.reporter import SilentReporter
from rostether.cli.access.completions import complete_ports
from rostether.cli.access.options import ADDRESS_HINTS, msg_path_option
from rostether.cli.board.simulated_links import simulated
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import argument, flag, option, option_group, shared
from rostether.cli.shell.output import json_option, write_json, write_line, write_result
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.conformance.case import Case, Outcome, Verdict
from rostether.conformance.checked_client import FIRST_ANSWER_S, CheckedClient, Connect
from rostether.conformance.program import ConformanceProgram
from rostether.conformance.run_cases import CASES, run_cases
from rostether.conformance.vectors import read_vectors
from rostether.device.device import Device
from rostether.errors import TransportTimeoutError
from rostether.mechanisms.block_end import closed_at_end
from rostether.transports.address import Address
from rostether.transports.address_parser import parse_address
from rostether.transports.opening import listen, open_transport
from rostether.transports.transport import Transport

# The longest wait of a case in a quick run.
QUICK_WAIT_S = 10.0

_MARKS = {"pass": "pass", "fail": "FAIL", "not applicable": "n/a"}


@dataclass(frozen=True, slots=True)
class ConformanceOptions:
    """The argument and the options of `conformance`."""

    address: str | None = argument(required=False, metavar="[ADDRESS]", shell_complete=complete_ports)
    quick: bool = flag("--quick", "Leave out the cases that wait longer than 10 s.")
    names: tuple[str, ...] = option("--case NAME", "Check only this case; may be repeated.", multiple=True)
    runs_program: bool = flag("--client", "Run the conformance program at ADDRESS, in Python.")
    lists_cases: bool = flag("--list", "List the cases.")
    prints_vectors: bool = flag("--vectors", "Print test vectors for codecs: bytes and values.")
    msg_paths: tuple[Path, ...] = shared(msg_path_option, ())
    as_json: bool = shared(json_option, False)


@verb(
    "conformance",
    """
    rostether conformance /dev/ttyACM0               a board that runs the example Conformance
    rostether conformance sim:Conformance.ino        the same on a simulated Uno
    rostether conformance tcp://:11411 --quick       a client that connects over the network
    rostether conformance --client tcp://127.0.0.1   run the client: the program in Python
    rostether conformance --list                     the cases, without a client
    """,
    hints=ADDRESS_HINTS,
)
@option_group("options", ConformanceOptions)
def conformance(options: ConformanceOptions) -> int:
    """Check whether a client library speaks the wire protocol.

    The client at ADDRESS must run the conformance program: the example sketch Conformance, or the same
    endpoints in another language. If it lacks some of them, the cases that need them are skipped. The
    exit code is 0 if no case failed.
    """
    if options.prints_vectors:
        for vector in read_vectors():
            write_json(vector)
        return EXIT_DONE
    cases = _chosen(options.names, quick=options.quick)
    if options.lists_cases:
        for each in cases:
            write_result(
                {"case": each.name, "requirement": each.requirement},
                f"{each.name:<20} {each.requirement}",
                as_json=options.as_json,
            )
        return EXIT_DONE
    if options.address is None:
        raise click.UsageError("give the client's address, for example /dev/ttyACM0 or tcp://:11411")
    if options.runs_program:
        run(_run_client(options.address), is_service=True)
        return EXIT_DONE
    return run(_check(options.address, cases, options.msg_paths, as_json=options.as_json))


def _chosen(names: Sequence[str], *, quick: bool) -> list[Case]:
    unknown = set(names) - {each.name for each in CASES}
    if unknown:
        raise click.UsageError(f"there is no case {sorted(unknown)[0]}; --list shows the cases")
    return [
        each
        for each in CASES
        if (not names or each.name in names) and not (quick and each.wait_s > QUICK_WAIT_S)
    ]


async def _run_client(address: str) -> None:
    device = Device(address)
    ConformanceProgram(device)
    async with device:
        write_line(f"the conformance program runs at {address}; Ctrl-C ends it")
        await asyncio.Event().wait()


async def _check(address: str, cases: Sequence[Case], msg_paths: Sequence[Path], *, as_json: bool) -> int:
    counts: Counter[Verdict] = Counter()
    async with (
        simulated([parse_address(address)], SilentReporter(), msg_paths) as (link,),
        _connecting(link) as connect,
        closed_at_end(CheckedClient(connect)) as client,
    ):
        await client.open()
        if not as_json:
            write_line(f"{address}: a client with {len(client.announcements)} announcements")
        async for outcome in run_cases(client, cases):
            counts[outcome.verdict] += 1
            _write(outcome, as_json=as_json)
    passed, failed, skipped = (counts[each] for each in Verdict)
    write_result(
        {"passed": passed, "failed": failed, "not_applicable": skipped},
        f"{passed} passed, {failed} failed, {skipped} not applicable",
        as_json=as_json,
    )
    return EXIT_FAILED if failed else EXIT_DONE


@asynccontextmanager
async def _connecting(link: Address) -> AsyncIterator[Connect]:
    """Yield a function that connects the client: opens its address, or waits for its connection."""
    if not link.listens:
        yield lambda: open_transport(link)
        return
    arrived: asyncio.Queue[Transport] = asyncio.Queue()

    async def accept() -> Transport:
        try:
            async with asyncio.timeout(FIRST_ANSWER_S):
                return await arrived.get()
        except TimeoutError:
            raise TransportTimeoutError(
                f"no client connected to {link} within {FIRST_ANSWER_S:g} s; start the client first"
            ) from None

    async with closed_at_end(await listen(link, arrived.put_nowait, connections=1)):
        yield accept


def _write(outcome: Outcome, *, as_json: bool) -> None:
    case = outcome.case
    if as_json:
        write_json(
            {
                "case": case.name,
                "verdict": outcome.verdict,
                "requirement": case.requirement,
                "seen": outcome.seen or None,
            }
        )
        return
    write_line(f"{_MARKS[outcome.verdict]:<5} {case.name}")
    if outcome.seen:
        write_line(f"    expected: {case.requirement}")
        write_line(f"    seen:     {outcome.seen}")
