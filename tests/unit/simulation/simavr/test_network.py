from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Coroutine
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from rostether.errors import BoardError
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from unit.simulation.simavr.programs import build, build_text
from unit.simulation.simavr.readings import named, number

pytestmark = pytest.mark.simavr

ECHO = """
#include <Ethernet.h>
EthernetClient client;
volatile uint8_t connects, refused, losses;
void setup() { uint8_t mac[6] = {2}; Ethernet.begin(mac, IPAddress(10, 0, 0, 2)); }
void loop() {
  if (!client.connected()) {
    if (connects > losses) losses++;
    client.stop();
    if (client.connect(IPAddress(192, 168, 1, 7), 11411)) connects++; else { refused++; delay(20); }
  }
  while (client.available()) client.write(client.read());
}
"""


@asynccontextmanager
async def server() -> AsyncIterator[
    tuple[str, asyncio.Queue[tuple[asyncio.StreamReader, asyncio.StreamWriter]]]
]:
    arrived: asyncio.Queue[tuple[asyncio.StreamReader, asyncio.StreamWriter]] = asyncio.Queue()
    writers = []

    async def take(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writers.append(writer)
        await arrived.put((reader, writer))

    listening = await asyncio.start_server(take, "127.0.0.1", 0)
    try:
        yield f"127.0.0.1:{listening.sockets[0].getsockname()[1]}", arrived
    finally:
        listening.close()
        for writer in writers:
            writer.close()
        await asyncio.gather(*(writer.wait_closed() for writer in writers), return_exceptions=True)


def networked(program: Path, place: str) -> Coroutine[Any, Any, SimulatedBoard]:
    return SimulatedBoard.start(program, link="none", commands=[f"network {place}"])


async def test_a_sketch_reaches_the_host_it_is_given(tmp_path: Path) -> None:
    program = await build_text(tmp_path, ECHO)
    async with server() as (place, arrived), await networked(program, place) as board:
        for expected in (1, 2):
            reader, writer = await asyncio.wait_for(arrived.get(), 60)
            data = bytes(range(256)) * 20
            writer.write(data)
            assert await asyncio.wait_for(reader.readexactly(len(data)), 60) == data
            assert await number(board, "connects") == expected
            writer.close()
            await writer.wait_closed()
        states = [(event["state"], event["asked"]) for event in named(board, "network")]
        assert states[:2] == [("connected", "192.168.1.7:11411"), ("closed", "192.168.1.7:11411")]


async def test_a_reset_ends_the_connection(tmp_path: Path) -> None:
    program = await build_text(tmp_path, ECHO)
    async with server() as (place, arrived), await networked(program, place) as board:
        reader, _ = await asyncio.wait_for(arrived.get(), 60)
        await board.reset()
        assert await asyncio.wait_for(reader.read(), 60) == b""
        await asyncio.wait_for(arrived.get(), 60)


async def test_without_a_network_connections_fail(tmp_path: Path) -> None:
    program = await build_text(tmp_path, ECHO)
    async with await SimulatedBoard.start(program, link="none", realtime=False, paused=True) as board:
        await board.run("3s")
        assert await number(board, "connects") == 0
        assert await number(board, "refused") > 0
        assert named(board, "network")[0]["state"] == "unreachable"


@pytest.mark.parametrize("place", ["", "host", "host:", ":7"])
async def test_invalid_places_are_refused(place: str) -> None:
    async with await SimulatedBoard.start(build("echo"), link="none") as board:
        with pytest.raises(BoardError, match="HOST:PORT"):
            await board.send_command(f"network {place}")
