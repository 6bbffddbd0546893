"""The bridge on real links of this machine: TCP, UDP, its own pseudo-terminal, and one of another program."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
import tty
from collections.abc import AsyncIterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from rostether.bridge.settings import BridgeSettings
from rostether.bridge.supervisor import Supervisor
from rostether.device.device import Device
from rostether.graph.memory_network import MemoryNetwork
from rostether.transports.address_parser import parse_address
from unit.bridge.doubles import RecordingReporter
from unit.bridge.nodes import STORE, text
from waiting import until

STRING = STORE.registry.message_type("std_msgs/String")


class Site:
    """A supervisor on real links, and a graph in memory."""

    def __init__(self) -> None:
        self.network = MemoryNetwork()
        self.reporter = RecordingReporter()
        self.supervisor = Supervisor(
            self.network.join, STORE, reporter=self.reporter, settings=BridgeSettings(grace_s=2.0)
        )


@pytest.fixture
async def site() -> AsyncIterator[Site]:
    site = Site()
    yield site
    await site.supervisor.close()


async def carry_both_ways(site: Site, link: str, node: str) -> None:
    """Send a message from a device on a link, and one to it."""
    peer = await site.network.join("/peer")
    reported: list[bytes] = []
    received: list[Any] = []
    await peer.subscribe("/chatter", STRING, reported.extend)
    publisher = await peer.advertise("/led", STRING)
    async with Device(link, store=STORE) as device:
        chatter = device.publisher("chatter", "std_msgs/String")
        device.subscriber("led", "std_msgs/String", received.append)
        await device.wait_connected(60.0)
        await until(lambda: publisher.subscriber_count, "the board's subscription")
        publisher.publish_raw([text("on")])
        await until(lambda: received, "the message to the board")
        await until(lambda: chatter.publish(data="hello") and reported, "the message from the board")
        assert received[0].data == "on"
        assert reported[0] == text("hello")
        assert [view.node for view in site.supervisor.boards()] == [node]


async def test_tcp(site: Site) -> None:
    await site.supervisor.start([parse_address("tcp://127.0.0.1:0")])
    await carry_both_ways(site, site.supervisor.listening_on[0], "/tcp_127_0_0_1")


async def test_udp(site: Site) -> None:
    await site.supervisor.start([parse_address("udp://127.0.0.1:0")])
    await carry_both_ways(site, site.supervisor.listening_on[0], "/udp_127_0_0_1")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
async def test_a_pseudo_terminal_of_the_bridge(site: Site, tmp_path: Path) -> None:
    link = tmp_path / "board"
    await site.supervisor.start([parse_address(f"pty:{link}")])
    await until(link.exists, "the link")
    await carry_both_ways(site, str(link), "/board")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
async def test_a_serial_port_that_goes_and_comes_back(site: Site, tmp_path: Path) -> None:
    """A simulator's terminal replaces a USB port: its link disappears, and later has another target."""
    port = tmp_path / "ttyACM0"
    await site.supervisor.start([parse_address(str(port))])
    await until(lambda: site.reporter.having("does not exist"), "the line")
    for _ in range(2):
        master, slave = os.openpty()
        tty.setraw(slave)
        port.symlink_to(os.ttyname(slave))
        asked = asyncio.Event()
        loop = asyncio.get_running_loop()

        def read(master: int = master, asked: asyncio.Event = asked) -> None:
            with contextlib.suppress(OSError):
                if b"\xff\xfe\x00\x00\xff\x00\x00\xff" in os.read(master, 4096):
                    asked.set()

        loop.add_reader(master, read)
        async with asyncio.timeout(60):
            await asked.wait()
        loop.remove_reader(master)
        port.unlink()
        os.close(slave)
        os.close(master)
    assert len(site.reporter.having("Connecting to")) == 2
    assert len(site.reporter.having("plug the board in again")) >= 1


async def test_many_devices_at_once(site: Site) -> None:
    await site.supervisor.start([parse_address("tcp://127.0.0.1:0?name=board")])
    peer = await site.network.join("/peer")
    reported: list[bytes] = []
    await peer.subscribe("/chatter", STRING, reported.extend)
    async with contextlib.AsyncExitStack() as stack:
        devices = [
            await stack.enter_async_context(Device(site.supervisor.listening_on[0], store=STORE))
            for _ in range(32)
        ]
        publishers = [device.publisher("chatter", "std_msgs/String") for device in devices]
        for device in devices:
            await device.wait_connected(60.0)
        for number, publisher in enumerate(publishers):
            await until(partial(publisher.publish, data=str(number)), "a publication")
        await until(lambda: len(reported) == 32, "a malformed message of each:")
        assert {payload[4:] for payload in reported} == {str(number).encode() for number in range(32)}
        assert len(site.supervisor.boards()) == 32
