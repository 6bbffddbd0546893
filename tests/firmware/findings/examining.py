"""Runs faulty sketches on simulated boards, and examines them with the doctor, all at once in real time."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeVar

from msgspec.structs import replace

from rostether.bridge.findings.finding import Code
from rostether.bridge.health.doctor import Diagnosis, Doctor
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuildOptions
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from rostether.transports.address import Address, SerialAddress
from rostether.transports.address_parser import parse_address
from rostether.transports.opening import open_transport
from rostether.transports.port_facts import PortFacts
from rostether.transports.transport import Transport
from unit.bridge.uart_port import UartPort

STORE = TypeStore(Registry())
PORT = "/dev/ttyACM0"
# A tenth of a second makes a board seem slow.
MAX_STALL_S = 0.03
TIMING_CODES = frozenset({Code.SLOW_LOOP, Code.CLOCK_DRIFT})
TRIES = 3
BoardAction = Callable[[SimulatedBoard], Awaitable[None]]


@dataclass(frozen=True, slots=True)
class Case:
    """A sketch, the commands to its board at the start, and what happens to the board during the examination.

    With `baud`, the sketch's rate, the line needs the same rate on both sides; the doctor begins at 57600.
    `built_with` are the definitions that the sketch is built with, by file name.
    """

    sketch: str
    commands: Sequence[str] = ()
    action: BoardAction | None = None
    watch_s: float = 4.0
    baud: int | None = None
    built_with: Mapping[str, str] | None = None
    known: Mapping[str, str] | None = None
    """Definitions that the doctor has."""
    timing_fault: Code | None = None
    """The expected finding about time. Other findings about time are ignored if this machine was too slow."""


async def examine_all(
    cases: Mapping[str, Case], folder: Path, expected: Mapping[str, list[Code]]
) -> dict[str, Diagnosis]:
    """Build all sketches, then examine all boards at once, and assert the codes of the findings.

    If other codes are found and this machine was too slow for real time, the board is examined again.
    """
    programs = await _gather({name: _build(case, folder / name) for name, case in cases.items()})
    found = await _gather(
        {name: _examine(case, programs[name], folder / name, expected[name]) for name, case in cases.items()}
    )
    wrong = {name: _codes(each) for name, each in found.items() if _codes(each) != expected[name]}
    assert not wrong, f"found {wrong}"
    return found


class Stalls:
    """Measures how long this process could not read its lines; data in this time seems late."""

    def __init__(self) -> None:
        self.longest_s = 0.0

    async def watch(self) -> None:
        """Measure until canceled."""
        clock = asyncio.get_running_loop().time
        while True:
            began_s = clock()
            await asyncio.sleep(0.01)
            self.longest_s = max(self.longest_s, clock() - began_s - 0.01)


T = TypeVar("T")


async def _gather(work: Mapping[str, Coroutine[None, None, T]]) -> dict[str, T]:
    async with asyncio.TaskGroup() as group:
        tasks = {name: group.create_task(each) for name, each in work.items()}
    return {name: task.result() for name, task in tasks.items()}


async def _build(case: Case, folder: Path) -> Path:
    sketch = folder / "faulty" / "faulty.ino"
    sketch.parent.mkdir(parents=True)
    sketch.write_text(case.sketch)
    paths = (_packages(folder / "sent", case.built_with),) if case.built_with else ()
    return (await build_sketch(sketch, find_board("uno"), BuildOptions(msg_paths=paths))).elf


async def _examine(case: Case, program: Path, folder: Path, expected: list[Code]) -> Diagnosis:
    store = STORE
    if case.known:
        store = TypeStore(Registry(paths=(_packages(folder / "known", case.known),)))
    for _ in range(TRIES):
        diagnosis, was_slow = await _watch(case, program, store)
        if was_slow and case.timing_fault is None:
            found = tuple(each for each in diagnosis.findings if each.code not in TIMING_CODES)
            diagnosis = replace(diagnosis, findings=found)
        if not was_slow or _codes(diagnosis) == expected:
            break
    return diagnosis


def _codes(diagnosis: Diagnosis) -> list[Code]:
    return [each.code for each in diagnosis.findings]


async def _watch(case: Case, program: Path, store: TypeStore) -> tuple[Diagnosis, bool]:
    """Return the diagnosis, and whether this machine was too slow for findings about time."""
    link: Literal["pty", "tcp"] = "pty" if case.baud is None else "tcp"
    stalls = Stalls()
    async with await SimulatedBoard.start(program, commands=case.commands, link=link) as board:
        watching = asyncio.create_task(stalls.watch())
        action = asyncio.ensure_future(case.action(board)) if case.action is not None else None
        try:
            diagnosis = await _diagnose(case, board, store)
        finally:
            tasks = [watching] if action is None else [watching, action]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        was_slow = stalls.longest_s > MAX_STALL_S or any(each.name == "behind" for each in board.recent)
    return diagnosis, was_slow


async def _diagnose(case: Case, board: SimulatedBoard, store: TypeStore) -> Diagnosis:
    if case.baud is None:
        return await Doctor(store, watch_s=case.watch_s).examine(parse_address(board.address))

    async def open_uart(address: Address) -> Transport:
        assert isinstance(address, SerialAddress)
        assert case.baud is not None
        return UartPort(await open_transport(parse_address(board.address)), address.baud, case.baud, PORT)

    async def facts(path: str) -> PortFacts:
        return PortFacts(path)

    doctor = Doctor(store, watch_s=case.watch_s, read_facts=facts, open_transport=open_uart)
    return await doctor.examine(parse_address(PORT))


def _packages(folder: Path, definitions: Mapping[str, str]) -> Path:
    """Write packages with definitions, whose keys are `package/msg/Name.msg`."""
    for path, text in definitions.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        package = folder / path.partition("/")[0]
        manifest = f"<package><name>{package.name}</name><version>1.0.0</version></package>"
        (package / "package.xml").write_text(manifest)
    return folder
