from __future__ import annotations

import asyncio
import os
import socket
import termios
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from rostether.errors import BoardError, TransportError
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from rostether.transports.opening import open_transport
from unit.simulation.simavr.programs import build
from unit.simulation.simavr.readings import named, number

pytestmark = pytest.mark.simavr

FAST: dict[str, Any] = {"realtime": False}


async def read_exactly(descriptor: int, count: int) -> bytes:
    data = b""
    loop = asyncio.get_running_loop()
    while len(data) < count:
        ready = asyncio.Event()
        loop.add_reader(descriptor, ready.set)
        try:
            await asyncio.wait_for(ready.wait(), 60)
        finally:
            loop.remove_reader(descriptor)
        data += os.read(descriptor, count - len(data))
    return data


def open_terminal(board: SimulatedBoard) -> int:
    return os.open(board.address, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)


class Collector:
    """Receives the bytes of a transport."""

    def __init__(self, count: int) -> None:
        self.got = b""
        self.complete = asyncio.Event()
        self._count = count

    def data_received(self, data: bytes) -> None:
        self.got += data
        if len(self.got) >= self._count:
            self.complete.set()

    def connection_lost(self, error: TransportError | None) -> None: ...
    def pause_writing(self) -> None: ...
    def resume_writing(self) -> None: ...


async def exchange(address: str, data: bytes) -> None:
    """Send data through a transport until it has been echoed."""
    transport = await open_transport(address)
    collector = Collector(len(data))
    transport.start(collector)
    try:
        # The first bytes may arrive before the board has detected the host.
        await asyncio.sleep(0.02)
        transport.write(data)
        await asyncio.wait_for(collector.complete.wait(), 60)
        assert collector.got == data
    finally:
        transport.close()
        await transport.wait_closed()


async def until_seen(board: SimulatedBoard) -> None:
    """Let the board run until it has detected that a host has connected or disconnected."""
    now = await board.cycles()
    while await board.cycles() < now + 64_000:
        await asyncio.sleep(0.002)


@pytest.mark.parametrize("options", [{}, FAST], ids=["real time", "fast"])
async def test_a_terminal_echoes_all_bytes(options: dict[str, Any]) -> None:
    async with await SimulatedBoard.start(build("echo"), **options) as board:
        terminal = open_terminal(board)
        await until_seen(board)
        data = bytes(range(256)) * 4
        os.write(terminal, data)
        assert await read_exactly(terminal, len(data)) == data
        os.close(terminal)


async def test_our_transport_opens_it(tmp_path: Path) -> None:
    link = tmp_path / "board"
    async with await SimulatedBoard.start(build("echo"), link_path=link):
        await exchange(str(link), b"ff fe \x00\xff\r\n\x03\x04")


async def test_the_terminal_stays_raw_and_keeps_no_old_bytes() -> None:
    async with await SimulatedBoard.start(build("tick")) as board:
        for _ in range(3):
            begun = await number(board, "ticks")
            while await number(board, "ticks") < begun + 5:
                await asyncio.sleep(0.005)
            terminal = open_terminal(board)
            assert not termios.tcgetattr(terminal)[3] & (termios.ICANON | termios.ECHO | termios.ISIG)
            assert (await read_exactly(terminal, 1))[0] >= begun + 5
            os.close(terminal)
            await until_seen(board)


async def test_a_host_that_does_not_read_loses_bytes_with_a_report() -> None:
    async with await SimulatedBoard.start(build("check", "BAUD=2000000UL")) as board:
        terminal = open_terminal(board)
        lost = await board.wait_for("lost_serial")
        assert lost["bytes"] > 0
        os.close(terminal)


async def test_without_a_clock_the_board_waits_for_its_host() -> None:
    async with await SimulatedBoard.start(build("check", "BAUD=2000000UL"), link="tcp", **FAST) as board:
        place = board.address.removeprefix("tcp://").partition("?")[0].split(":")
        reader, writer = await asyncio.open_connection(place[0], int(place[1]))
        got = await reader.readexactly(1)
        await asyncio.sleep(0.2)
        while len(got) < 500_000:
            got += await reader.read(65536)
        assert all((b - a) & 0xFF == 1 for a, b in pairwise(got))
        assert named(board, "lost_serial") == []
        writer.close()
        await writer.wait_closed()


async def test_tcp_accepts_one_host_after_the_other() -> None:
    async with await SimulatedBoard.start(build("echo"), link="tcp") as board:
        for word in (b"first", b"second"):
            await exchange(board.address, word)


async def test_a_port_in_use_is_reported() -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as taken,
        pytest.raises(BoardError, match="cannot be opened"),
    ):
        await SimulatedBoard.start(build("echo"), link="tcp", tcp_port=taken.getsockname()[1])


async def test_autoreset_is_what_usb_boards_do() -> None:
    async with await SimulatedBoard.start(build("echo"), commands=["autoreset on"]) as board:
        waiting = asyncio.create_task(board.wait_for("reset", lambda event: event["cause"] == "host"))
        await asyncio.sleep(0)
        terminal = open_terminal(board)
        await waiting
        os.close(terminal)


async def test_a_host_that_sends_too_fast_waits() -> None:
    async with await SimulatedBoard.start(build("check", "BAUD=115200UL")) as board:
        terminal = open_terminal(board)
        await until_seen(board)
        sent = 0
        while sent < 20_000:
            try:
                sent += os.write(terminal, bytes((sent + i) & 0xFF for i in range(min(512, 20_000 - sent))))
            except BlockingIOError:
                # It reads like a host; the board sends all the time.
                await asyncio.sleep(0.01)
                os.read(terminal, 65536)
        while await number(board, "received") < 20_000:
            await asyncio.sleep(0.02)
            os.read(terminal, 65536)
        assert (await number(board, "wrong"), await number(board, "overruns")) == (0, 0)
        os.close(terminal)
