from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping
from functools import partial
from pathlib import Path

import pytest

from rostether.bridge.findings.board_health import BoardHealth
from rostether.bridge.settings import BoardNodes, BridgeSettings
from rostether.bridge.supervisor import Links, Supervisor
from rostether.errors import GraphError, InvalidNameError, MasterUnreachableError, TransportOpenError
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import Level
from rostether.rosserial import topic_id as ids
from rostether.transports.address import Address
from rostether.transports.address_parser import parse_address
from rostether.transports.memory import MemoryTransport, memory_pair
from rostether.transports.peers import PeerEntry
from rostether.transports.transport import Transport
from unit.bridge.doubles import RecordingReporter
from unit.bridge.nodes import STORE, text, topic_info
from unit.bridge.raw_board import RawBoard
from unit.bridge.sketch_board import SketchBoard, every, hello, publish
from unit.bridge.uart_port import UartPort
from unit.bridge.virtual_time import run
from waiting import until

CHATTER = (ids.PUBLISHER, topic_info("chatter", topic_id=125))
PORT = "/dev/null"  # exists everywhere; the test's `open` replaces it


class FakeListener:
    def __init__(self, address: Address, on_transport: Callable[[Transport], None]) -> None:
        self.address = str(address)
        self.on_transport = on_transport
        self.is_closed = False

    async def close(self) -> None:
        self.is_closed = True


class Site:
    """A supervisor with links and listeners of the test."""

    def __init__(self, settings: BridgeSettings) -> None:
        self.network = MemoryNetwork()
        self.reporter = RecordingReporter()
        self.listeners: list[FakeListener] = []
        self.boards: list[RawBoard] = []
        self.announcements = [CHATTER]
        self.open_errors: list[TransportOpenError] = []
        self.join_errors: list[Exception] = []
        self.opened: list[str] = []
        self.supervisor = Supervisor(
            self.join,
            STORE,
            reporter=self.reporter,
            settings=settings,
            links=Links(open_transport=self.open, listen=self.listen),
        )

    async def join(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> MemoryGraph:
        if self.join_errors:
            raise self.join_errors.pop(0)
        return await self.network.join(node_name, namespace=namespace, remappings=remappings)

    async def open(self, address: Address) -> Transport:
        if self.open_errors:
            raise self.open_errors.pop(0)
        self.opened.append(str(address))
        ours, theirs = memory_pair()
        self.boards.append(RawBoard(theirs, *self.announcements))
        return ours

    async def listen(
        self, address: Address, on_transport: Callable[[Transport], None], *, entry: PeerEntry | None = None
    ) -> FakeListener:
        if self.open_errors:
            raise self.open_errors.pop(0)
        self.listeners.append(FakeListener(address, on_transport))
        return self.listeners[-1]

    async def start(self, *addresses: str) -> None:
        await self.supervisor.start([parse_address(address) for address in addresses])

    def connect(self, peer: str = "tcp 127.0.0.1:5000") -> RawBoard:
        """Connect a board to the first listener."""
        ours, theirs = memory_pair()
        ours.peer = peer
        ours.remote = peer.partition(" ")[2].rpartition(":")[0].strip("[]") or None
        board = RawBoard(theirs, *self.announcements)
        self.boards.append(board)
        self.listeners[0].on_transport(ours)
        return board

    def nodes(self) -> set[str]:
        return set(self.network.nodes)

    def connected(self) -> set[str]:
        return {view.node for view in self.supervisor.boards() if view.is_connected}

    async def serving(self, *nodes: str) -> None:
        def all_there() -> bool:
            views = {view.node: view for view in self.supervisor.boards()}
            return all(node in views and views[node].is_settled for node in nodes)

        await until(all_there, f"{nodes} to be served")


@pytest.fixture
async def site() -> AsyncIterator[Site]:
    site = Site(BridgeSettings(grace_s=0.5))
    yield site
    await site.supervisor.close()


async def test_many_links_are_served_each_as_a_node(site: Site) -> None:
    await site.start(f"{PORT}?name=left", f"{PORT}?name=right", "tcp://:11411")
    site.connect("tcp 192.168.1.7:40000")
    await site.serving("/left", "/right", "/tcp_192_168_1_7")
    assert set(site.network.snapshot().topics["/chatter"].publishers) == site.nodes()


async def test_a_radio_that_is_plugged_in_later_is_served(site: Site) -> None:
    site.open_errors = [TransportOpenError("no serial port /dev/ttyUSB0")] * 2
    await site.start("xbee:/dev/ttyUSB0")
    await until(lambda: site.listeners, "the radio")
    site.connect("xbee 0x0001")
    await site.serving("/xbee_0x0001")
    assert len(site.reporter.having("no serial port /dev/ttyUSB0 (trying again)")) == 1
    site.open_errors = [TransportOpenError("port 11411 is in use")]
    with pytest.raises(TransportOpenError, match="11411"):
        await site.start("tcp://:11411")


async def test_a_board_whose_task_is_cancelled_is_no_longer_counted(site: Site) -> None:
    await site.start(f"{PORT}?name=left")
    await site.serving("/left")
    assert site.supervisor._objects._boards == 1
    for task in site.supervisor._tasks:
        task.cancel()
    await until(lambda: site.supervisor._objects._boards == 0, "the count")


async def test_boards_of_one_name_are_numbered(site: Site) -> None:
    await site.start("tcp://:11411?name=arm")
    for _ in range(3):
        site.connect()
    await site.serving("/arm", "/arm_2", "/arm_3")


async def test_one_name_in_two_namespaces_is_not_a_clash(site: Site) -> None:
    await site.start(f"{PORT}?name=opencr&ns=tb3_0", f"{PORT}?name=opencr&ns=tb3_1")
    await site.serving("/tb3_0/opencr", "/tb3_1/opencr")


async def test_topics_go_into_the_links_namespace(site: Site) -> None:
    await site.start(f"{PORT}?name=arm&ns=robot1")
    await site.serving("/robot1/arm")
    await until(lambda: "/robot1/chatter" in site.network.snapshot().topics, "the topic")


async def test_topics_go_into_a_namespace_of_the_board_if_asked() -> None:
    site = Site(BridgeSettings())
    site.supervisor = Supervisor(
        site.join, STORE, nodes=BoardNodes(ns_per_board=True), links=Links(open_transport=site.open)
    )
    await site.start(f"{PORT}?name=arm")
    await until(lambda: "/arm/chatter" in site.network.snapshot().topics, "the topic")
    assert site.nodes() == {"/arm"}
    await site.supervisor.close()


async def test_a_port_that_is_not_there_is_waited_for(site: Site, tmp_path: Path) -> None:
    port = tmp_path / "ttyACM0"
    await site.start(str(port))
    await until(lambda: site.reporter.having("does not exist"), "the line")
    assert site.opened == []
    port.touch()
    await site.serving("/ttyACM0")
    assert len(site.reporter.having(str(port))) == 2, site.reporter.texts
    assert f"Connecting to {port} at 57600 baud" in site.reporter.texts


async def test_a_port_that_cannot_be_opened_is_tried_again_in_one_line(site: Site) -> None:
    site.open_errors = [TransportOpenError("no program listens on robot:11411") for _ in range(3)]
    await site.start("tcp://robot:11411?connect=yes&name=arm")
    await site.serving("/arm")
    assert len(site.reporter.having("no program listens")) == 1


async def test_a_lost_board_comes_back_to_its_node() -> None:
    site = Site(BridgeSettings(grace_s=3600))
    await site.start(f"{PORT}?name=arm")
    await site.serving("/arm")
    before = site.network.nodes["/arm"]
    site.boards[0].transport.close()
    await until(lambda: len(site.boards) == 2, "the second opening")
    await site.serving("/arm")
    assert site.network.nodes["/arm"] is before
    assert site.reporter.having("ended the connection")
    await site.supervisor.close()


async def test_a_board_that_stays_away_leaves_the_graph(site: Site) -> None:
    await site.start("tcp://:11411?name=arm")
    board = site.connect()
    await site.serving("/arm")
    board.transport.close()
    await until(lambda: not site.connected(), "the loss")
    assert site.nodes() == {"/arm"}
    await until(lambda: not site.nodes(), "the node to leave")
    site.connect()
    await site.serving("/arm")


async def test_a_board_that_lost_power_gets_its_name_back(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.bridge.board_registry.HALF_OPEN_S", 0.05)
    await site.start("tcp://0.0.0.0:11411")
    site.connect("tcp 192.168.1.7:40000")
    await site.serving("/tcp_192_168_1_7")
    await asyncio.sleep(0.06)
    again = site.connect("tcp 192.168.1.7:40001")
    await until(lambda: again.received[ids.TOPIC_REQUEST], "the topic request")
    assert site.nodes() == {"/tcp_192_168_1_7"}
    assert site.boards[0].is_lost or site.connected() == {"/tcp_192_168_1_7"}
    arrived: list[bytes] = []
    peer = await site.network.join("/peer")
    await peer.subscribe("/chatter", STORE.registry.message_type("std_msgs/String"), arrived.extend)
    await site.serving("/tcp_192_168_1_7")
    again.send(125, text("back"))
    await until(lambda: arrived, "the message")


async def test_a_board_that_is_not_silent_keeps_its_name(site: Site) -> None:
    await site.start("tcp://0.0.0.0:11411")
    first = site.connect("tcp 192.168.1.7:40000")
    await site.serving("/tcp_192_168_1_7")
    site.connect("tcp 192.168.1.7:40001")
    await asyncio.sleep(0)
    first.send(125, text("still here"))
    await site.serving("/tcp_192_168_1_7", "/tcp_192_168_1_7_2")


def _has(items: list[bool], count: int) -> bool:
    return len(items) == count


async def test_a_connection_from_this_machine_is_a_program(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    endings: list[bool] = []
    monkeypatch.setattr(
        BoardHealth, "disconnected", lambda self, error, *, is_program: endings.append(is_program)
    )
    await site.start("tcp://0.0.0.0:11411")
    for count, peer in enumerate(("tcp 127.0.0.1:40000", "tcp [::1]:40000", "tcp 192.168.1.7:40000"), 1):
        board = site.connect(peer)
        await until(partial(board.received.__getitem__, ids.TOPIC_REQUEST), "the topic request")
        board.transport.close()
        await until(partial(_has, endings, count), "the end")
    assert endings == [True, True, False]


async def test_a_master_that_is_away_is_waited_for(site: Site) -> None:
    site.join_errors = [
        MasterUnreachableError("no ROS master answers at http://robot:11311") for _ in range(2)
    ]
    await site.start(f"{PORT}?name=arm")
    await site.serving("/arm")
    assert len(site.reporter.having("no ROS master answers")) == 1


async def test_a_defect_in_one_link_stays_there(site: Site) -> None:
    site.join_errors = [RuntimeError("a defect of ours")]
    await site.start("tcp://:11411?name=arm")
    site.connect()
    await until(lambda: site.reporter.having("a defect of ours"), "the line")
    site.connect()
    await site.serving("/arm")


async def test_a_node_whose_name_is_taken_is_served_no_more(site: Site) -> None:
    await site.start(f"{PORT}?name=arm")
    await site.serving("/arm")
    other = await site.network.join("/arm")
    await asyncio.wait_for(site.supervisor.wait_done(), 60)
    assert site.network.nodes["/arm"] is other
    assert site.boards[0].order[-1] == ids.TX_STOP
    assert len(site.boards) == 1
    assert [level for level, _, node in site.reporter.lines if node == "/arm"][-1] is Level.ERROR
    assert not site.supervisor.has_failed


async def test_an_error_that_ends_the_only_link_is_a_failure(site: Site) -> None:
    site.join_errors = [GraphError("cannot listen on 1.2.3.4")]
    await site.start(f"{PORT}?name=arm")
    await asyncio.wait_for(site.supervisor.wait_done(), 60)
    assert site.supervisor.has_failed


async def test_a_board_whose_node_was_shut_down_joins_when_it_connects_again(site: Site) -> None:
    await site.start("tcp://:11411?name=arm")
    site.connect()
    await site.serving("/arm")
    await site.network.nodes["/arm"].close("/rosnode requested a shutdown")
    await until(lambda: site.boards[0].is_lost and not site.nodes(), "the end of the session")
    assert site.boards[0].order[-1] == ids.TX_STOP
    assert site.reporter.texts.count(
        "/rosnode requested a shutdown; its board is not served until it reconnects"
    )
    site.connect()
    await site.serving("/arm")


async def test_a_board_whose_node_was_shut_down_joins_when_it_is_plugged_in_again(
    site: Site, tmp_path: Path
) -> None:
    port = tmp_path / "ttyACM0"
    port.touch()
    await site.start(f"{port}?name=arm")
    await site.serving("/arm")
    await site.network.nodes["/arm"].close("/rosnode requested a shutdown")
    await until(lambda: site.boards[0].is_lost and not site.nodes(), "the end of the session")
    assert site.reporter.having("not served until you unplug it and plug it in again")
    await asyncio.sleep(0.2)
    assert len(site.boards) == 1
    port.unlink()
    await until(lambda: site.reporter.having("waiting until it is plugged in"), "the port to be gone")
    port.touch()
    await site.serving("/arm")


async def test_a_board_of_a_node_whose_name_was_taken_is_sent_away(site: Site) -> None:
    await site.start("tcp://:11411?name=arm")
    site.connect()
    await site.serving("/arm")
    other = await site.network.join("/arm")
    await until(lambda: site.boards[0].is_lost, "the end of the session")
    lines = len(site.reporter.lines)
    again = site.connect()
    await until(lambda: again.is_lost, "the board to be sent away")
    assert site.network.nodes["/arm"] is other
    assert len(site.reporter.lines) <= lines + 1


async def test_a_kept_node_exists_before_its_board_and_ends_the_bridge(site: Site) -> None:
    supervisor = Supervisor(
        site.join,
        STORE,
        reporter=site.reporter,
        nodes=BoardNodes(keeps_node=True),
        links=Links(open_transport=site.open, listen=site.listen),
    )
    await supervisor.start([parse_address("tcp://:11411?name=arm&ns=lab")])
    assert site.nodes() == {"/lab/arm"}
    node = site.network.nodes["/lab/arm"]
    board = site.connect()
    await until(lambda: "/lab/chatter" in site.network.snapshot().topics, "the topic")
    assert site.network.nodes["/lab/arm"] is node
    second = site.connect()
    await until(lambda: "/lab/arm_2" in site.nodes(), "the second board")
    await site.network.nodes["/lab/arm_2"].close()
    await until(lambda: second.is_lost, "the second board to be sent away")
    done = asyncio.ensure_future(supervisor.wait_done())
    await asyncio.sleep(0.01)
    assert not done.done(), "only the node to keep ends it all"
    await site.network.join("/lab/arm")
    await asyncio.wait_for(done, 60)
    assert board.order[-1] == ids.TX_STOP
    await supervisor.close()


async def test_a_node_to_keep_waits_for_the_master_before_anything_listens(site: Site) -> None:
    supervisor = Supervisor(
        site.join,
        STORE,
        reporter=site.reporter,
        nodes=BoardNodes(keeps_node=True),
        links=Links(open_transport=site.open, listen=site.listen),
    )
    site.join_errors = [MasterUnreachableError("no ROS master answers") for _ in range(1000)]
    start = asyncio.ensure_future(supervisor.start([parse_address("tcp://:11411?name=arm")]))
    await until(lambda: site.reporter.having("no ROS master answers"), "the line")
    assert site.listeners == []
    site.join_errors.clear()
    await asyncio.wait_for(start, 60)
    assert site.nodes() == {"/arm"}
    await supervisor.close()
    assert site.nodes() == set()


async def test_invalid_names_are_refused_at_the_start(site: Site) -> None:
    with pytest.raises(InvalidNameError):
        await site.start("tcp://:11411", f"{PORT}?ns=no-dashes")
    assert site.listeners == []


async def test_closing_stops_every_board_and_leaves_nothing(site: Site) -> None:
    await site.start(f"{PORT}?name=left", f"{PORT}?name=right", "tcp://:11411")
    site.connect()
    await site.serving("/left", "/right", "/tcp_127_0_0_1")
    await asyncio.wait_for(site.supervisor.close(), 60.0)
    await until(lambda: all(board.is_lost for board in site.boards), "the boards to learn of it")
    assert all(board.order[-1] == ids.TX_STOP for board in site.boards)
    assert site.nodes() == set()
    assert site.listeners[0].is_closed
    await site.supervisor.wait_done()
    await site.supervisor.close()


async def test_closing_waits_for_no_hanging_graph_and_no_hanging_transport(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    await site.start(f"{PORT}?name=arm")
    await site.serving("/arm")

    async def hang(*_: object) -> None:
        await asyncio.sleep(60.0)

    monkeypatch.setattr(MemoryGraph, "close", hang)
    monkeypatch.setattr(MemoryTransport, "wait_closed", hang)
    loop = asyncio.get_running_loop()
    before = loop.time()
    await site.supervisor.close()
    assert loop.time() - before < 30.0


async def test_closing_while_everything_waits(site: Site, tmp_path: Path) -> None:
    site.join_errors = [MasterUnreachableError("no ROS master answers") for _ in range(1000)]
    await site.start(str(tmp_path / "never"), f"{PORT}?name=arm")
    await until(lambda: site.reporter.having("no ROS master answers"), "the line")
    await asyncio.wait_for(site.supervisor.close(), 60.0)
    assert site.nodes() == set()


async def test_a_view_shows_the_state_of_a_board(site: Site) -> None:
    await site.start(f"{PORT}?name=arm")
    await site.serving("/arm")
    site.boards[0].send(125, text("a"), b"bad")
    await until(lambda: site.supervisor.boards()[0].endpoints[0].misfit_count, "the messages")
    (view,) = site.supervisor.boards()
    (endpoint,) = view.endpoints
    assert (endpoint.role, endpoint.name, endpoint.type) == ("publisher", "chatter", "std_msgs/String")
    assert (endpoint.message_count, endpoint.misfit_count, endpoint.is_attached) == (1, 1, True)
    assert view.protocol_version == 2
    assert view.received_bytes > 0
    assert view.sent_bytes > 0
    assert view.peer == "memory second"
    site.boards[0].transport.close()
    await until(lambda: not site.connected(), "the loss")
    assert site.supervisor.boards()[0].peer == ""


async def test_a_client_that_never_sends_a_frame_is_disconnected(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.bridge.supervisor.FIRST_FRAME_LIMIT_S", 1.0)
    await site.start("tcp://:11411")
    site.connect("tcp 192.168.1.7:40000")
    silent, theirs = memory_pair()
    site.listeners[0].on_transport(silent)
    await asyncio.wait_for(theirs.wait_closed(), 60)
    await asyncio.wait_for(silent.wait_closed(), 60)
    await site.serving("/tcp_192_168_1_7")
    assert "/tcp_192_168_1_7" in site.connected(), "a board that sends data stays connected"


async def test_a_peer_that_disconnects_without_a_frame_leaves_no_node() -> None:
    site = Site(BridgeSettings(grace_s=3600))
    await site.start("tcp://:11411")
    silent, theirs = memory_pair()
    site.listeners[0].on_transport(silent)
    await until(lambda: site.supervisor.boards(), "the connection to be taken")
    theirs.write(b"GET / HTTP/1.1\r\n\r\n" + bytes(range(256)))
    theirs.close()
    await until(lambda: not site.nodes(), "the node to leave")
    await site.supervisor.close()


async def test_a_board_that_returns_silently_keeps_its_topics() -> None:
    site = Site(BridgeSettings(grace_s=3600))
    await site.start("tcp://:11411?name=arm")
    board = site.connect()
    await site.serving("/arm")
    board.transport.close()
    await until(lambda: not site.connected(), "the loss")
    silent, theirs = memory_pair()
    site.listeners[0].on_transport(silent)
    await until(site.connected, "the board to be back")
    theirs.close()
    await until(lambda: not site.connected(), "the second loss")
    assert site.nodes() == {"/arm"}
    await site.supervisor.close()


def test_a_wrong_baud_rate_is_named_within_seconds_and_forgotten_when_it_is_corrected() -> None:
    async def main() -> None:
        site = Site(BridgeSettings())
        wire, board_end = memory_pair()
        port = UartPort(wire, 57600, 115200)

        async def open_port(address: Address) -> Transport:
            return port

        supervisor = Supervisor(
            site.join, STORE, reporter=site.reporter, links=Links(open_transport=open_port)
        )
        sketch = SketchBoard(board_end, turn=every(0.1, publish("chatter", hello)))
        sketch.publisher("chatter").plug_in()
        await supervisor.start([parse_address(f"{PORT}?baud=57600")])
        # A board that was never connected sends nothing.
        for cause in ("whether its baud rate is 57600", "probably a baud rate other than 57600"):
            site.reporter.lines.clear()
            port.set_board_baud(115200)
            await asyncio.sleep(10.0)
            # The sketch is uploaded again with the right rate.
            port.set_board_baud(57600)
            await asyncio.sleep(70.0)
            (fault,) = [text for level, text, _ in site.reporter.lines if level > Level.INFO]
            assert cause in fault
            assert "/chatter" in site.network.snapshot().topics
            (view,) = supervisor.boards()
            assert view.is_settled
        await sketch.unplug()
        await supervisor.close()

    run(main())
