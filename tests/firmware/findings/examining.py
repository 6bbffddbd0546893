"""Faulty sketches on simulated boards, and the doctor at their serial lines, all at once in real time."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rostether.boards.simavr.simulated_board import SimulatedBoard
from rostether.bridge.doctor import Diagnosis, Doctor
from rostether.firmware.build import BuildOptions, build_sketch, find_board
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from rostether.transports.address import Address, SerialAddress, parse_address
from rostether.transports.opening import open_transport
from rostether.transports.port_facts import PortFacts
from rostether.transports.transport import Transport
from unit.bridge.uart_port import UartPort

STORE = TypeStore(Registry())
PORT = "/dev/ttyACM0"
Happening = Callable[[SimulatedBoard], Awaitable[None]]


@dataclass(frozen=True, slots=True)
class Case:
    """A sketch, what its board is told at its start, and what happens to the board meanwhile.

    `baud` is the sketch's, for a line on which both sides need the same one, and the doctor begins at 57600.
    `sent_as` are definitions that the sketch is built with, by file.
    """

    sketch: str
    words: Sequence[str] = ()
    happening: Happening | None = None
    watch_s: float = 4.0
    baud: int | None = None
    sent_as: Mapping[str, str] | None = None
    known: Mapping[str, str] | None = None
    """Definitions that the doctor has."""


async def examine_all(cases: Mapping[str, Case], folder: Path) -> dict[str, Diagnosis]:
    """Examine all boards at once."""
    tasks = {name: asyncio.create_task(_examine(case, folder / name)) for name, case in cases.items()}
    try:
        return {name: await task for name, task in tasks.items()}
    finally:
        for task in tasks.values():
            task.cancel()
        await asyncio.gather(*tasks.values(), return_exceptions=True)


async def _examine(case: Case, folder: Path) -> Diagnosis:
    sketch = folder / "faulty" / "faulty.ino"
    sketch.parent.mkdir(parents=True)
    sketch.write_text(case.sketch)
    paths = (_packages(folder / "sent", case.sent_as),) if case.sent_as else ()
    built = await build_sketch(sketch, find_board("uno"), BuildOptions(msg_paths=paths))
    store = STORE
    if case.known:
        store = TypeStore(Registry(paths=(_packages(folder / "known", case.known),)))
    board = await SimulatedBoard.start(
        built.elf, words=case.words, link="pty" if case.baud is None else "tcp"
    )
    async with board:
        happening = asyncio.ensure_future(case.happening(board)) if case.happening is not None else None
        try:
            return await _diagnose(case, board, store)
        finally:
            if happening is not None:
                happening.cancel()
                await asyncio.gather(happening, return_exceptions=True)


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
    """Write packages with their definitions, given by `package/msg/Name.msg`."""
    for place, text in definitions.items():
        file = folder / place
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        package = folder / place.partition("/")[0]
        manifest = f"<package><name>{package.name}</name><version>1.0.0</version></package>"
        (package / "package.xml").write_text(manifest)
    return folder
