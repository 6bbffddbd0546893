"""Several relays, and boards in both graphs, all as processes: every message arrives once."""

from __future__ import annotations

import asyncio
import os
import signal
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack

import pytest_asyncio

from contract.graphs import SET_BOOL, STRING, TRUE, Inbox, answer, answer_set_bool, string, wait_for_nodes
from contract.zenoh_graphs import open_session
from interop.ros1_peers import free_port
from programs import Peer, start_command
from rostether.device.device import Device
from rostether.errors import RostetherError
from rostether.graph.ports import Graph, Publisher
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import join_ros1
from waiting import until

# For the long run, set RELAY_TEST_S=60.
FLOW_S = float(os.environ.get("RELAY_TEST_S", "2"))
PERIOD_S = 0.01


class World:
    """A ROS 1 master, a zenoh router, a node in each graph, and the processes that join both."""

    def __init__(self, stack: AsyncExitStack, master_uri: str, router_port: int, graphs: list[Graph]) -> None:
        self.graphs = graphs
        self._stack = stack
        self._graph_options = (
            *("--master", master_uri, "--ros2", "zenoh", "--zenoh-router", "never"),
            *("--zenoh-connect", f"tcp/127.0.0.1:{router_port}"),
        )

    async def start(self, *arguments: str) -> Peer:
        """Start a command on both graphs."""
        # A separate master: no environment variable may name another graph.
        environment = {"ROS_DOMAIN_ID": "0", "ROS_DISTRO": "jazzy"}
        # The last option of a name counts, so a command may name another master.
        peer = await start_command(
            arguments[0], *self._graph_options, *arguments[1:], environment=environment
        )
        self._stack.push_async_callback(peer.stop, signal.SIGKILL)
        return peer

    async def relay(self, *arguments: str) -> Peer:
        """Start a relay, and wait until it is in both graphs."""
        peer = await self.start("relay", *arguments)
        await peer.wait_for("Joining ROS 2")
        await self.wait_for_nodes("relay", at_least=1)
        return peer

    async def wait_for_nodes(self, part: str, *, at_least: int) -> None:
        """Wait until both graphs have `at_least` nodes whose names contain a part."""
        for graph in self.graphs:
            while sum(part in name for name in (await graph.snapshot()).nodes) < at_least:
                await asyncio.sleep(0.02)


@pytest_asyncio.fixture
async def world() -> AsyncIterator[World]:
    async with AsyncExitStack() as stack:
        master = await MasterServer.start(port=0)
        stack.push_async_callback(master.close)
        port = free_port()
        router = await open_session(port, is_router=True)
        stack.push_async_callback(router.close)
        session = await open_session(port, is_router=False)
        stack.push_async_callback(session.close)
        graphs: list[Graph] = [
            await join_ros1("/peer", environment=RosEnvironment.read({}).with_master(master.uri)),
            await session.join("/peer"),
        ]
        for graph in graphs:
            stack.push_async_callback(graph.close)
        await wait_for_nodes(graphs[1])
        yield World(stack, master.uri, port, graphs)


class Flow:
    """Numbered messages on a topic of one graph or both, and the messages that a subscriber in each graph
    receives.
    """

    def __init__(self, world: World, topic: str) -> None:
        self.inboxes = [Inbox() for _ in world.graphs]
        self._world = world
        self._topic = topic
        self._talkers: list[Publisher] = []

    async def open(self, *publishing: int) -> None:
        """Subscribe in both graphs, and advertise in the graphs with the numbers `publishing`."""
        graphs = self._world.graphs
        for graph, inbox in zip(graphs, self.inboxes, strict=True):
            await graph.subscribe(self._topic, STRING, inbox.store)
        self._talkers = [await graphs[number].advertise(self._topic, STRING) for number in publishing]

    async def wait_until_connected(self, *others: Inbox) -> None:
        """Send until both graphs and the others receive from every publisher, then begin to count."""
        seen: set[bytes] = set()
        while True:
            for number, talker in enumerate(self._talkers):
                talker.publish_raw([string(f"start {number}")])
            await asyncio.sleep(0.05)
            for inbox in (*self.inboxes, *others):
                seen = set(inbox.payloads)
                if not all(string(f"start {number}") in seen for number in range(len(self._talkers))):
                    break
            else:
                break
        # Until pending messages have arrived, and both relays have started.
        await asyncio.sleep(3)
        for inbox in (*self.inboxes, *others):
            inbox.payloads.clear()

    async def run(self) -> list[bytes]:
        """Send at 100 Hz from every publisher; return what was sent."""
        sent = []
        loop = asyncio.get_running_loop()
        began_s = loop.time()
        for turn in range(int(FLOW_S / PERIOD_S)):
            for number, talker in enumerate(self._talkers):
                sent.append(string(f"{number}: {turn}"))
                talker.publish_raw(sent[-1:])
            await asyncio.sleep(max(0.0, began_s + (turn + 1) * PERIOD_S - loop.time()))
        return sent


async def assert_received_once(inbox: Inbox, sent: list[bytes]) -> None:
    """Wait for all sent messages, then half a second for duplicates."""
    await until(lambda: len(inbox.payloads) >= len(sent))
    await asyncio.sleep(0.5)
    counts = Counter(inbox.payloads)
    twice = {text: count for text, count in counts.items() if count > 1}
    assert not twice, f"{len(twice)} of {len(sent)} messages came more than once"
    assert counts.keys() == set(sent)
    print(f"sent {len(sent)}, received {len(inbox.payloads)}")


async def test_two_relays_copy_a_topic_once(world: World) -> None:
    flow = Flow(world, "/chatter")
    await flow.open(0, 1)
    relays = [await world.relay("/*"), await world.relay("/*")]
    await world.wait_for_nodes("relay", at_least=2)
    await flow.wait_until_connected()
    sent = await flow.run()
    for inbox in flow.inboxes:
        await assert_received_once(inbox, sent)
    lines = [line for relay in relays for line in relay.lines if "/chatter" in line]
    for direction in ("from ROS 1 to ROS 2", "from ROS 2 to ROS 1"):
        assert sum("relaying /chatter" in line and direction in line for line in lines) >= 1, lines


async def test_two_relays_offer_a_service_once_and_stop_with_its_server(world: World) -> None:
    ros1, ros2 = world.graphs
    calls = 0

    async def refuse(_: bytes) -> bytes:
        nonlocal calls
        calls += 1
        raise RostetherError("not today")

    server = await ros2.advertise_service("/pull", SET_BOOL, refuse)
    push_server = await ros1.advertise_service("/push", SET_BOOL, answer_set_bool)
    for _ in range(2):
        await world.relay("--service", "/pull", "--service", "/push=std_srvs/SetBool")
    await world.wait_for_nodes("relay", at_least=2)
    for graph, service in ((ros1, "/pull"), (ros2, "/push")):
        while service not in (await graph.snapshot()).services:
            await asyncio.sleep(0.02)
    await asyncio.sleep(3)
    assert len((await ros2.snapshot()).services["/push"].providers) == 1
    assert (await ros2.snapshot()).services["/pull"].providers == ("/peer",)
    assert (await ros1.snapshot()).services["/push"].providers == ("/peer",)
    assert await ros2.call_service("/push", SET_BOOL, TRUE, timeout_s=60) == answer("done")
    try:
        await ros1.call_service("/pull", SET_BOOL, TRUE, timeout_s=60)
    except RostetherError as error:
        assert str(error).count("responded with an error") <= 2, str(error)
    assert calls == 1
    # Neither relay treats the other one as a server.
    await server.close()
    await push_server.close()
    for graph in world.graphs:
        while {"/pull", "/push"} & (await graph.snapshot()).services.keys():
            await asyncio.sleep(0.02)


async def test_a_relay_with_a_board_in_both_graphs(world: World) -> None:
    port = free_port()
    await world.start("serve", "--ros1", "--no-mdns", f"tcp://127.0.0.1:{port}?name=board")
    relay = await world.relay("/*")
    flow = Flow(world, "/command")
    await flow.open(0, 1)
    received = [Inbox() for _ in world.graphs]
    for graph, inbox in zip(world.graphs, received, strict=True):
        await graph.subscribe("/sensor", STRING, inbox.store)
    commands = Inbox()
    async with Device(f"tcp://127.0.0.1:{port}") as device:
        device.subscriber(
            "command", "std_msgs/String", lambda message: commands.store([string(message.data)])
        )
        sensor = device.publisher("sensor", "std_msgs/String")
        await world.wait_for_nodes("board", at_least=1)
        await flow.wait_until_connected(commands)
        while not all(inbox.payloads for inbox in received):
            sensor.publish(data="start")
            await asyncio.sleep(0.05)
        await asyncio.sleep(0.5)
        for inbox in received:
            inbox.payloads.clear()
        running = asyncio.ensure_future(flow.run())
        count = int(FLOW_S / PERIOD_S)
        for number in range(count):
            sensor.publish(data=f"{number}")
            await asyncio.sleep(PERIOD_S)
        sent = await running
        for inbox in (*flow.inboxes, commands):
            await assert_received_once(inbox, sent)
        for inbox in received:
            await assert_received_once(inbox, [string(f"{number}") for number in range(count)])
    await relay.wait_for("board")


async def test_relays_of_two_robots_copy_from_one_master_to_the_other(world: World) -> None:
    """Two relays of one robot and one relay of another robot, with separate masters and one ROS 2 graph."""
    second = await MasterServer.start(port=0)
    other_node = await join_ros1("/peer", environment=RosEnvironment.read({}).with_master(second.uri))
    try:
        inbox = Inbox()
        await other_node.subscribe("/chatter", STRING, inbox.store)
        flow = Flow(world, "/chatter")
        await flow.open(0, 1)
        for _ in range(2):
            await world.relay("/*")
        other = await world.relay("/*", "--master", second.uri)
        await world.wait_for_nodes("relay", at_least=2)
        await flow.wait_until_connected(inbox)
        sent = await flow.run()
        for each in (*flow.inboxes, inbox):
            await assert_received_once(each, sent)
        # For the second robot, the first robot's relay is an ordinary node.
        assert "relays it" not in other.text
    finally:
        await other_node.close()
        await second.close()


async def test_another_relay_replaces_a_killed_one(world: World) -> None:
    ros1, ros2 = world.graphs
    await ros2.advertise_service("/pull", SET_BOOL, answer_set_bool)
    await ros1.advertise_service("/push", SET_BOOL, answer_set_bool)
    flow = Flow(world, "/chatter")
    await flow.open(0, 1)
    relay = await world.relay("/*", "--service", "/pull", "--service", "/push")

    async def call_both_services() -> None:
        for graph, service in ((ros1, "/pull"), (ros2, "/push")):
            async with asyncio.timeout(60):
                while True:
                    try:
                        assert await graph.call_service(service, SET_BOOL, TRUE, timeout_s=5) == answer(
                            "done"
                        )
                        break
                    except RostetherError:
                        await asyncio.sleep(0.1)

    await call_both_services()
    relay.process.kill()
    await relay.finish()
    # First a relay that starts later replaces the killed one, then a relay that already waits.
    successor = await world.relay("/*", "--service", "/pull", "--service", "/push")
    await call_both_services()
    waiting = await world.relay("/*", "--service", "/pull", "--service", "/push")
    await world.wait_for_nodes("relay", at_least=2)
    await waiting.wait_for("relays it")
    successor.process.kill()
    await successor.finish()
    await call_both_services()
    await flow.wait_until_connected()
    sent = await flow.run()
    for inbox in flow.inboxes:
        await assert_received_once(inbox, sent)
