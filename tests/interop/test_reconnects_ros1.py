"""Hundreds of reconnects at `rostether serve` leave nothing in Debian's master and in the kernel."""

from __future__ import annotations

import asyncio
import sys
import xmlrpc.client
from pathlib import Path
from typing import Any

import pytest

from effort import effort
from interop.ros1_peers import Ros1Peers, free_port
from programs import started
from unit.bridge.line_boards import TcpBoard, numbered
from waiting import until

# tests/unit/bridge/test_reconnects.py counts the bytes of each reconnect.
RECONNECTS = effort(300, 1000)
# Until then, caches and the allocator grow.
WARM_UP = 200
MAX_GROWTH_KB = 2048
IDLE_S = 5.0
MAX_IDLE_CPU = 0.005


class Process:
    """The kernel's data about a process."""

    def __init__(self, pid: int) -> None:
        self._folder = Path(f"/proc/{pid}")

    @property
    def descriptors(self) -> int:
        return len(list((self._folder / "fd").iterdir()))

    @property
    def threads(self) -> int:
        return len(list((self._folder / "task").iterdir()))

    @property
    def resident_kb(self) -> int:
        for line in (self._folder / "status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1])
        raise AssertionError("no VmRSS")

    @property
    def cpu_s(self) -> float:
        return int((self._folder / "schedstat").read_text().split()[0]) / 1e9


def registrations(master_uri: str) -> list[list[tuple[str, tuple[str, ...]]]]:
    """Return the master's publishers, subscribers and services."""
    with xmlrpc.client.ServerProxy(master_uri) as proxy:
        master: Any = proxy
        tables = master.getSystemState("/test")[2]
    return [sorted((name, tuple(sorted(nodes))) for name, nodes in table) for table in tables]


async def _connect_and_disconnect(board: TcpBoard, number: int) -> None:
    requests = board.requests
    await board.connect()
    while board.requests == requests:
        await asyncio.sleep(0.001)
    await board.send(numbered(number))
    await asyncio.sleep(0.002)
    await board.hang_up()


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
async def test_reconnects_leave_no_registrations_and_no_resources(
    roscore: Ros1Peers,
) -> None:
    port = free_port()
    async with started("serve", f"tcp://:{port}?name=arm", ROS_MASTER_URI=roscore.master_uri) as serve:
        process = Process(serve.process.pid)
        await serve.wait_for("Waiting for boards")
        board = TcpBoard(port)
        for number in range(WARM_UP):
            await _connect_and_disconnect(board, number)
        await serve.wait_for("Setup publisher on count")
        await board.connect()
        async with asyncio.timeout(60):
            while True:
                await asyncio.sleep(2.5)
                known = await asyncio.to_thread(registrations, roscore.master_uri)
                if ("/count", ("/arm",)) in known[0]:
                    break
        before = process.descriptors, process.threads
        resident_kb = process.resident_kb
        await board.hang_up()
        for number in range(RECONNECTS):
            await _connect_and_disconnect(board, number)
        await board.connect()
        await asyncio.sleep(2.5)
        async with asyncio.timeout(60):
            while await asyncio.to_thread(registrations, roscore.master_uri) != known:
                await asyncio.sleep(0.1)
        await until(lambda: (process.descriptors, process.threads) == before, "descriptors as before")
        assert process.resident_kb - resident_kb < MAX_GROWTH_KB
        # The board is silent. The garbage of the earlier connections is collected up to 10 s later.
        idle = [await _idle_cpu(process)]
        while idle[-1] >= MAX_IDLE_CPU and len(idle) < 3:
            idle.append(await _idle_cpu(process))
        assert idle[-1] < MAX_IDLE_CPU, f"{idle} of a CPU while nothing happens"
        await board.hang_up()


async def _idle_cpu(process: Process) -> float:
    used_s = process.cpu_s
    await asyncio.sleep(IDLE_S)
    return (process.cpu_s - used_s) / IDLE_S
