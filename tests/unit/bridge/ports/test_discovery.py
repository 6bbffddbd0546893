"""Boards on pseudo-terminals are found, removed, and found again on other ports; other devices are never
opened.
"""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from rostether.bridge.settings import BridgeSettings
from rostether.bridge.supervisor import Supervisor
from rostether.device import Device
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.ports.device_book import DeviceBook
from rostether.ports.devices_toml import parse_devices_toml
from rostether.ports.known_boards import KnownBoards
from rostether.transports.address_parser import parse_address
from rostether.transports.port_holders import find_port_user
from unit.bridge.doubles import RecordingReporter
from unit.bridge.lateness import lateness
from unit.bridge.machine import CH340, MODEM, UNO, Machine
from unit.bridge.nodes import STORE, text
from waiting import until

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")

GRACE_S = 0.6


class Site:
    """A supervisor that searches for boards on the test's machine."""

    def __init__(self, folder: Path) -> None:
        self.machine = Machine(folder)
        self.network = MemoryNetwork()
        self.reporter = RecordingReporter()
        self.known = KnownBoards()
        self.supervisor: Supervisor

    async def start(self, toml: str = "", *addresses: str, grace_s: float = GRACE_S) -> None:
        devices: DeviceBook = parse_devices_toml(toml)
        self.supervisor = Supervisor(
            self.join,
            STORE,
            reporter=self.reporter,
            settings=BridgeSettings(grace_s=grace_s),
            devices=devices,
        )
        links = [parse_address(address) for address in addresses]
        await self.supervisor.start(links)
        self.supervisor.discover(self.known, ports=self.machine.ports, excluded=links)

    async def join(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> MemoryGraph:
        return await self.network.join(node_name, namespace=namespace, remappings=remappings)

    def connected(self) -> dict[str, str]:
        return {view.node: view.peer for view in self.supervisor.boards() if view.is_connected}

    def settled(self, node: str) -> bool:
        return any(view.node == node and view.is_settled for view in self.supervisor.boards())

    def nodes(self) -> set[str]:
        return set(self.network.nodes)

    async def received(self, topic: str = "/chatter") -> list[bytes]:
        """Subscribe to a topic with another node; return the list of the received messages."""
        graph = await self.network.join("/listener")
        got: list[bytes] = []
        await graph.subscribe(topic, STORE.registry.message_type("std_msgs/String"), got.extend)
        return got


@pytest.fixture
async def site(tmp_path: Path) -> AsyncIterator[Site]:
    (tmp_path / "dev").mkdir()
    site = Site(tmp_path / "dev")
    yield site
    await site.supervisor.close()


def chatter(device: Device) -> None:
    device.publisher("chatter", "std_msgs/String")


def now_s() -> float:
    return asyncio.get_running_loop().time()


async def talk(device: Device, stop: asyncio.Event) -> None:
    """Publish until `stop` is set, like a sketch: messages that the host does not receive are lost."""
    publisher = device.publisher("chatter", "std_msgs/String")
    while not stop.is_set():
        publisher.publish(data="hello")
        await asyncio.sleep(0.01)


async def test_a_board_is_found_named_and_connected_when_it_is_plugged_in(site: Site) -> None:
    await site.start()
    await until(lambda: site.reporter.having("No known board is plugged in yet"), "the search to begin")
    plugged_s = now_s()
    async with site.machine.board("ttyACM0", chatter, serial_number="7533", **UNO):
        async with lateness() as late:
            await until(lambda: site.settled("/board_7533"), "the board")
        # Not by the next check of all ports, a minute later.
        assert now_s() - plugged_s - late.total_s < 5.0
        assert site.connected() == {"/board_7533": site.machine.path("ttyACM0")}
        assert len(site.reporter.having("Found a board at")) == 1
    lost_s = now_s()
    async with lateness() as late:
        await until(lambda: not site.connected(), "the loss to be noticed")
        assert "/board_7533" in site.nodes()
        await until(lambda: "/board_7533" not in site.nodes(), "the node to leave")
    assert GRACE_S - 0.1 < now_s() - lost_s < GRACE_S + 1.0 + late.total_s


async def test_boards_that_are_there_already_are_found(site: Site) -> None:
    async with AsyncExitStack() as stack:
        for number in range(3):
            board = site.machine.board(f"ttyACM{number}", chatter, serial_number=f"7{number}", **UNO)
            await stack.enter_async_context(board)
        await site.start()
        await until(lambda: len(site.connected()) == 3, "all boards")
        assert set(site.connected()) == {"/board_70", "/board_71", "/board_72"}


@pytest.mark.parametrize(
    ("marks", "node"),
    [
        ({"serial_number": "7533", **UNO}, "/board_7533"),
        ({"usb_location": "1-1.2:1.0", **CH340}, "/usb_1_1_2_1_0"),
    ],
)
async def test_a_board_that_comes_back_as_another_port_is_the_same_node(
    marks: dict[str, Any], node: str, site: Site
) -> None:
    await site.start(grace_s=60.0)
    received = await site.received()
    stop = asyncio.Event()
    async with site.machine.board("ttyACM0", **marks) as board:
        talking = asyncio.ensure_future(talk(board, stop))
        await until(lambda: received, "messages")
        stop.set()
        await talking
    await until(lambda: not site.connected(), "the loss to be noticed")
    registrations = site.network.nodes[node]
    received.clear()
    stop.clear()
    async with site.machine.board("ttyACM1", **marks) as board:
        speaks_s = now_s()
        talking = asyncio.ensure_future(talk(board, stop))
        async with lateness() as late:
            await until(lambda: received, "messages from the other port")
        assert now_s() - speaks_s - late.total_s < 0.5
        assert site.connected() == {node: site.machine.path("ttyACM1")}
        assert site.network.nodes[node] is registrations
        stop.set()
        await talking


async def test_other_devices_ports_are_never_opened(site: Site) -> None:
    await site.start()
    with open_terminal(site.machine.path("ttyUSB2")) as modem, open_terminal(site.machine.path("ttyS0")):
        site.machine.mark("ttyUSB2", **MODEM)
        site.machine.mark("ttyS0")
        async with site.machine.board("ttyACM0", chatter, serial_number="7533", **UNO):
            await until(lambda: site.connected(), "the board beside it")
            await until(lambda: site.reporter.having("--probe 2c7c:0125"), "the line about the modem")
        assert site.machine.opens.keys() == {"ttyACM0"}
        os.set_blocking(modem, False)
        with pytest.raises(OSError):
            os.read(modem, 1)
    assert len(site.reporter.having("is not opened")) == 1


async def test_the_user_may_have_any_port_probed_wherever_it_is(site: Site, tmp_path: Path) -> None:
    (tmp_path / "sim").mkdir()
    await site.start(f'[discovery]\nprobe = ["2c7c:0125", "{tmp_path}/sim/tty*"]')
    async with (
        site.machine.board("ttyUSB2", chatter, **MODEM),
        Device(f"pty:{tmp_path}/sim/ttySIM", store=STORE) as elsewhere,
    ):
        chatter(elsewhere)
        await until(lambda: len(site.connected()) == 2, "both boards")
        assert set(site.connected()) == {"/ttyUSB2", "/ttySIM"}


async def test_a_port_the_user_ignores_is_never_opened(site: Site) -> None:
    await site.start('[discovery]\nignore = ["2341:0043"]')
    async with (
        site.machine.board("ttyACM0", chatter, serial_number="1", **UNO),
        site.machine.board("ttyACM1", chatter, serial_number="2", **(UNO | {"usb_product_id": 0x10})),
    ):
        await until(lambda: site.connected(), "the other board")
    assert site.machine.opens.keys() == {"ttyACM1"}


async def test_a_file_names_and_sets_a_board(site: Site) -> None:
    await site.start(
        '[devices.arm]\nserial_number = "7533"\nnamespace = "/lab"\nremap = { chatter = "/talk" }\n'
        "grace_s = 0.1\n"
    )
    received = await site.received("/talk")
    stop = asyncio.Event()
    async with site.machine.board("ttyACM0", serial_number="7533", **MODEM) as board:
        talking = asyncio.ensure_future(talk(board, stop))
        await until(lambda: received, "messages under the other name")
        stop.set()
        await talking
        assert set(site.connected()) == {"/lab/arm"}
    lost_s = now_s()
    async with lateness() as late:
        await until(lambda: "/lab/arm" not in site.nodes(), "the node to leave")
    assert now_s() - lost_s - late.total_s < GRACE_S


async def test_a_board_without_a_required_topic_is_reported_once(site: Site) -> None:
    await site.start('[devices.arm]\nserial_number = "7533"\nrequired_topics = ["/chatter", "/imu"]\n')
    async with site.machine.board("ttyACM0", chatter, serial_number="7533", **UNO):
        await until(lambda: site.reporter.having("does not announce /imu"), "the line")
        assert "it announces chatter" in site.reporter.having("does not announce")[0]
    async with site.machine.board("ttyACM1", chatter, serial_number="7533", **UNO) as board:
        board.publisher("imu", "std_msgs/String")
        await until(lambda: site.settled("/arm"), "the right sketch")
    assert len(site.reporter.having("does not announce")) == 1


async def test_a_depth_in_the_file_bounds_what_waits_for_a_board(site: Site) -> None:
    await site.start('[devices.arm]\nserial_number = "7533"\nqueue_depths = { "/text" = 3 }\n')
    peer = await site.network.join("/peer")
    publisher = await peer.advertise("/text", STORE.registry.message_type("std_msgs/String"))
    machine = site.machine
    machine.mark("ttyACM0", serial_number="7533", **UNO)
    async with Device(f"pty:{machine.path('ttyACM0')}", store=STORE) as device:
        got: list[str] = []
        device.subscriber("text", "std_msgs/String", lambda message: got.append(message.data))
        await until(lambda: publisher.subscriber_count, "the board's subscription")
        machine.opened[0].pause_writing()
        for number in range(50):
            publisher.publish_raw([text(str(number))])
        await asyncio.sleep(0)
        machine.opened[0].resume_writing()
        await until(lambda: got and got[-1] == "49", "the newest")
        assert got == ["47", "48", "49"]


async def test_a_speed_in_the_file_needs_no_probe(site: Site) -> None:
    await site.start('[devices.arm]\nserial_number = "7533"\nbaud = 115200\n')
    async with site.machine.board("ttyUSB0", chatter, serial_number="7533", **CH340):
        await until(lambda: site.settled("/arm"), "the board")
    assert site.reporter.having("Connecting to")[0].endswith("at 115200 baud")
    assert not site.reporter.having("Found")


async def test_a_port_in_use_is_left_alone_reported_once_and_served_later(site: Site) -> None:
    machine = site.machine
    machine.users[machine.path("ttyACM0")] = "screen (PID 4711)"
    await site.start()
    async with machine.board("ttyACM0", chatter, serial_number="7533", **UNO):
        await until(lambda: site.reporter.having("in use by screen (PID 4711)"), "the line")
        assert machine.opens == {}
        machine.users.clear()
        await until(lambda: site.connected(), "the board")
    assert len(site.reporter.having("in use")) == 1


async def test_a_program_that_really_has_the_port_open_is_not_disturbed(site: Site) -> None:
    machine = site.machine
    machine.ports = replace(machine.ports, find_port_user=find_port_user)
    await site.start()
    path = machine.path("ttyACM0")
    code = f"import os, sys; os.open({path!r}, os.O_RDWR | os.O_NOCTTY); print(); sys.stdout.flush(); input()"
    async with Device(f"pty:{path}", store=STORE):
        program = subprocess.Popen(
            [sys.executable, "-S", "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        try:
            assert program.stdout is not None
            await asyncio.to_thread(program.stdout.readline)
            machine.mark("ttyACM0", serial_number="7533", **UNO)
            (machine.folder / "news").touch()
            await until(lambda: site.reporter.having(f"(PID {program.pid})"), "the line")
            assert machine.opens == {}
            program.kill()
            await until(lambda: site.connected(), "the board")
        finally:
            program.kill()
            program.communicate()


async def test_another_device_is_probed_once_and_again_after_another_program_used_it(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.rosserial.baud_probe.BOOT_S", 0.1)
    monkeypatch.setattr("rostether.rosserial.baud_probe.PATIENT_DWELL_S", 0.1)
    monkeypatch.setattr("rostether.bridge.ports.found_port.CHECK_PERIOD_S", 0.02)
    await site.start()
    path = site.machine.path("ttyACM0")
    with open_terminal(path) as board:
        site.machine.mark("ttyACM0", **UNO)

        def is_left_alone() -> bool:
            os.write(board, b"I print\r\n")
            return bool(site.reporter.having("ignoring it"))

        await until(is_left_alone, "the end of the questions")
        assert "sends text" in site.reporter.having("ignoring it")[0]
        await asyncio.sleep(0.2)
        assert site.machine.opens["ttyACM0"] == 1
        assert not site.nodes()
        os.utime(path)
        await until(lambda: site.machine.opens["ttyACM0"] == 2, "another question")


async def test_a_port_that_had_a_board_before_is_probed_again(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.rosserial.baud_probe.BOOT_S", 0.1)
    monkeypatch.setattr("rostether.rosserial.baud_probe.PATIENT_DWELL_S", 0.1)
    monkeypatch.setattr("rostether.bridge.ports.found_port.CHECK_PERIOD_S", 0.02)
    monkeypatch.setattr("rostether.bridge.ports.found_port.FIRST_REPROBE_S", 0.1)
    site.known.remember("usb 2341:0043 7533", 57600)
    await site.start()
    with open_terminal(site.machine.path("ttyACM0")):
        site.machine.mark("ttyACM0", serial_number="7533", **UNO)
        await until(lambda: site.machine.opens["ttyACM0"] == 3, "more questions")
    assert len(site.reporter.having("ignoring it")) == 1


async def test_a_port_that_is_served_by_its_address_is_not_served_twice(site: Site) -> None:
    path = site.machine.path("ttyACM0")
    await site.start("", f"{path}?name=arm")
    async with site.machine.board("ttyACM0", chatter, serial_number="7533", **UNO):
        await until(lambda: site.settled("/arm"), "the board")
        async with site.machine.board("ttyACM1", chatter, serial_number="7534", **UNO):
            await until(lambda: site.settled("/board_7534"), "the other board")
        assert site.machine.opens.keys() == {"ttyACM1"}


async def test_a_board_whose_node_is_shut_down_is_left_alone_until_it_is_plugged_in_again(site: Site) -> None:
    await site.start()
    async with site.machine.board("ttyACM0", chatter, serial_number="7533", **UNO):
        await until(lambda: site.settled("/board_7533"), "the board")
        await site.network.nodes["/board_7533"].close("requested by a test")
        await until(lambda: site.reporter.having("not served until you unplug it"), "the line")
        await until(lambda: not site.connected(), "the end")
        async with site.machine.board("ttyACM1", chatter, serial_number="7534", **UNO):
            await until(lambda: site.settled("/board_7534"), "another board")
        assert site.machine.opens["ttyACM0"] == 1
    await until(lambda: not site.nodes(), "both to be unplugged")
    async with site.machine.board("ttyACM0", chatter, serial_number="7533", **UNO):
        await until(lambda: site.settled("/board_7533"), "the board that was plugged in again")


async def test_a_list_that_fails_once_is_made_again(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    lists = site.machine.list_ports
    failures = [OSError("gone while it was described")]

    def sometimes() -> list[Any]:
        if failures:
            raise failures.pop()
        return lists()

    site.machine.ports = replace(site.machine.ports, list_ports=sometimes)
    await site.start()
    async with site.machine.board("ttyACM0", chatter, serial_number="7533", **UNO):
        await until(lambda: site.connected(), "the board")
    assert not failures


class open_terminal:
    """A device that is not a board: a terminal that only the test reads and writes."""

    def __init__(self, link: str) -> None:
        self._link = Path(link)
        self._near, far = os.openpty()
        self._name = os.ttyname(far)
        os.close(far)
        import tty

        tty.setraw(self._near)

    def __enter__(self) -> int:
        self._link.symlink_to(self._name)
        return self._near

    def __exit__(self, *_error: object) -> None:
        self._link.unlink()
        os.close(self._near)
