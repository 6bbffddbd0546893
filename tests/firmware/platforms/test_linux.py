"""The node as a Linux program with the real bridge, over a serial port and TCP."""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import os
import socket
import struct
import termios
import time
import tty
from pathlib import Path

import pytest

from firmware.platforms.late_network import late_network
from firmware.platforms.node_harness import TIMEOUT_S, node_harness
from firmware.platforms.programs import running
from unit.bridge.lateness import lateness
from waiting import until

pytestmark = pytest.mark.gcc


async def test_exchanges_messages_over_tcp(linux_program: Path) -> None:
    async with (
        node_harness() as harness,
        harness.bridge("tcp://127.0.0.1:0") as (address,),
        running(linux_program, address.removeprefix("tcp://")),
    ):
        await harness.exchange_messages()


async def test_receives_a_message_whose_packets_arrive_late(linux_program: Path) -> None:
    async with (
        node_harness() as harness,
        harness.bridge("tcp://127.0.0.1:0") as (address,),
        late_network(address) as network_address,
        running(linux_program, network_address),
    ):
        await harness.wait_for_counts()
        assert await harness.ask("x" * 200) == "x" * 200


async def test_exchanges_messages_over_a_serial_port(linux_program: Path, tmp_path: Path) -> None:
    port = tmp_path / "port"
    async with (
        node_harness() as harness,
        harness.bridge(f"pty:{port}"),
        running(linux_program, port, "1000000"),
    ):
        await harness.exchange_messages()


async def test_uses_the_port_of_the_environment(linux_program: Path) -> None:
    async with node_harness() as harness, harness.bridge("tcp://127.0.0.1:0") as (address,):
        network_address = f"localhost:{address.rpartition(':')[2]}"
        async with running(linux_program, environment={"ROSSERIAL_PORT": network_address}):
            await harness.wait_for_counts()


async def test_reconnects_within_two_seconds_of_the_bridge(linux_program: Path) -> None:
    async with node_harness() as harness, contextlib.AsyncExitStack() as node:
        async with harness.bridge("tcp://127.0.0.1:0") as (address,):
            await node.enter_async_context(running(linux_program, address.removeprefix("tcp://")))
            await harness.wait_for_counts()
        # Long enough for the longest pause between its attempts.
        await asyncio.sleep(2.0)
        began_s = time.monotonic()
        async with harness.bridge(address):
            async with lateness() as late:
                await harness.wait_for_counts(1)
            assert time.monotonic() - began_s - late.total_s < 2.0
            await harness.exchange_messages()


async def test_reconnects_to_a_serial_port_that_returns(linux_program: Path, tmp_path: Path) -> None:
    port = tmp_path / "port"
    async with node_harness() as harness, running(linux_program, port):
        for _ in range(2):
            async with harness.bridge(f"pty:{port}"):
                await harness.wait_for_counts()
                assert await harness.ask("hello") == "hello"


async def test_survives_a_host_that_resets_the_connection_while_it_writes(linux_program: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(TIMEOUT_S)
        host, port = server.getsockname()
        async with running(linux_program, f"{host}:{port}") as process:
            for _ in range(3):
                connection, _ = await asyncio.to_thread(server.accept)
                # With unread data, closing resets the connection.
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\x01\0\0\0\0\0\0\0")
                assert await asyncio.to_thread(connection.recv, 16)
                connection.close()
            assert process.returncode is None


@pytest.mark.parametrize(
    "baud", [9600, 57600, 115200, 250000, 500000, 1000000, 2000000, 3000000], ids="{} baud".format
)
async def test_sets_the_baud_rate(linux_program: Path, baud: int) -> None:
    master, slave = os.openpty()
    try:
        tty.setraw(slave)
        async with running(linux_program, os.ttyname(slave), str(baud)):
            await until(lambda: _speed(slave) == baud, f"{baud} baud")
    finally:
        os.close(master)
        os.close(slave)


def _speed(fd: int) -> int:
    """Return the output speed in baud from the kernel's structure, because termios only has standard
    rates.
    """
    line = fcntl.ioctl(fd, 0x802C542A, bytes(44))
    speed: int = struct.unpack("<4I20s2I", line)[-1]
    assert termios.tcgetattr(fd)[3] & termios.ECHO == 0
    return speed
