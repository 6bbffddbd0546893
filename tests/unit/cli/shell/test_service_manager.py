from __future__ import annotations

import asyncio
import os
import socket
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from rostether.cli.shell.service_manager import reporting


@pytest.fixture
def manager(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[socket.socket]:
    address = f"@rostether-test-{tmp_path.name}-{os.getpid()}"
    monkeypatch.setenv("NOTIFY_SOCKET", address)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(f"\0{address[1:]}")
        listening.settimeout(60)
        yield listening


async def test_a_service_is_ready_alive_and_stops(
    manager: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The system keeps ten datagrams for a slow reader.
    monkeypatch.setenv("WATCHDOG_USEC", "60000")

    async def main() -> str:
        # Children must not report in its place.
        assert "NOTIFY_SOCKET" not in os.environ
        await asyncio.sleep(0.1)
        return "done"

    assert await reporting(main()) == "done"
    manager.setblocking(False)
    received: list[bytes] = []
    while not received or received[-1] != b"STOPPING=1":
        received.append(manager.recv(100))
    assert received[0] == b"READY=1"
    assert received.count(b"WATCHDOG=1") >= 2


async def test_a_loop_that_is_held_sends_nothing(
    manager: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WATCHDOG_USEC", "20000")

    async def main() -> None:
        await asyncio.sleep(0.05)
        manager.setblocking(False)
        with pytest.raises(BlockingIOError):
            while True:
                manager.recv(100)
        time.sleep(0.2)
        with pytest.raises(BlockingIOError):
            manager.recv(100)

    await reporting(main())


async def test_without_a_manager() -> None:
    async def main() -> int:
        return 3

    assert await reporting(main()) == 3


async def test_a_manager_that_is_gone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "gone"))

    async def main() -> int:
        await asyncio.sleep(0)
        return 3

    assert await reporting(main()) == 3
