"""A TurtleBot3 Burger in ROS 1 and ROS 2 at the same time: each topic has its type and its rate in both."""

from __future__ import annotations

import asyncio
import itertools
import statistics
import time
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack
from dataclasses import dataclass
from functools import partial
from typing import Any

import pytest
import pytest_asyncio

from contract.graphs import Inbox, wait_for_snapshot
from contract.zenoh_graphs import open_session
from firmware.examples.stage import EXAMPLES, STORE, open_graph
from firmware.ros2.serving import serving
from interop.ros1_peers import free_port
from programs import Peer
from rostether.graph.ports import Graph, Snapshot
from waiting import until

pytestmark = [pytest.mark.gcc, pytest.mark.asyncio(loop_scope="module"), pytest.mark.timeout(300)]

TIMEOUT_S = 60.0
DOMAIN = 11
SENT_HZ = {
    "/imu": ("sensor_msgs/Imu", 200),
    "/magnetic_field": ("sensor_msgs/MagneticField", 200),
    "/odom": ("nav_msgs/Odometry", 30),
    "/tf": ("tf2_msgs/TFMessage", 30),
    "/joint_states": ("sensor_msgs/JointState", 30),
    "/sensor_state": ("turtlebot3_msgs/SensorState", 30),
    "/battery_state": ("sensor_msgs/BatteryState", 30),
    "/cmd_vel_rc100": ("geometry_msgs/Twist", 30),
    "/version_info": ("turtlebot3_msgs/VersionInfo", 1),
    "/firmware_version": ("turtlebot3_msgs/VersionInfo", 1),
    "/diagnostics": ("diagnostic_msgs/DiagnosticArray", 1),
}
RECEIVED = {
    "/cmd_vel": "geometry_msgs/Twist",
    "/motor_power": "std_msgs/Bool",
    "/reset": "std_msgs/Empty",
    "/sound": "turtlebot3_msgs/Sound",
}
# Two seconds, which is enough to distinguish 30 Hz from 28 Hz.
WINDOW = 60


@dataclass
class World:
    """The bridge with the robot, and a node in each graph."""

    bridge: Peer
    graphs: dict[str, Graph]


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def world() -> AsyncIterator[World]:
    master, router = free_port(), free_port()
    environment = {
        "ROS_MASTER_URI": f"http://localhost:{master}",
        "ROS_DOMAIN_ID": str(DOMAIN),
        "ZENOH_CONFIG_OVERRIDE": f'listen/endpoints=["tcp/127.0.0.1:{router}"]',
    }
    address = f"sim:{EXAMPLES / 'TurtleBot3Burger'}?board=opencr&name=burger&range=0.2"
    async with AsyncExitStack() as stack:
        options = ("--ros1", "--ros2", "zenoh", "--zenoh-router", "always")
        bridge = await stack.enter_async_context(serving(*options, address, environment=environment))
        await bridge.wait_for("Setup subscriber on sound", TIMEOUT_S)
        session = await open_session(router, is_router=False, domain_id=DOMAIN)
        stack.push_async_callback(session.close)
        ros1 = await stack.enter_async_context(open_graph(environment["ROS_MASTER_URI"]))
        yield World(bridge, {"ROS 1": ros1.raw, "ROS 2": await session.join("/onlooker")})


async def listen(graph: Graph, topic: str, type_name: str) -> Inbox:
    """Subscribe to a topic."""
    inbox = Inbox()
    await graph.subscribe(topic, STORE.registry.message_type(type_name), inbox.store)
    return inbox


def shown_type(graph: str, topic: str, type_name: str) -> str:
    """Return the type of a topic as the graph shows it."""
    if graph == "ROS 2":
        return type_name.replace("/", "/msg/")
    return "tf/tfMessage" if topic == "/tf" else type_name


def has_types(expected: dict[str, str], seen: Snapshot) -> bool:
    return expected.items() <= {topic: entry.type for topic, entry in seen.topics.items()}.items()


async def test_each_topic_has_its_type_and_its_rate_in_both_graphs(world: World) -> None:
    inboxes: dict[tuple[str, str], Inbox] = {}
    for name, graph in world.graphs.items():
        types = {topic: kind for topic, (kind, _) in SENT_HZ.items()} | RECEIVED
        expected = {topic: shown_type(name, topic, kind) for topic, kind in types.items()}
        await wait_for_snapshot(graph, partial(has_types, expected))
        for topic, (kind, _) in SENT_HZ.items():
            inboxes[name, topic] = await listen(graph, topic, kind if name == "ROS 2" else expected[topic])
    await until(lambda: all(inbox.payloads for inbox in inboxes.values()), "each topic in each graph")
    # On a busy machine, some windows are too slow.
    deadline_s = time.monotonic() + TIMEOUT_S
    while wrong := await wrong_rates(inboxes):
        assert time.monotonic() < deadline_s, wrong


async def wrong_rates(inboxes: dict[tuple[str, str], Inbox]) -> list[str]:
    """Count the messages of each topic during WINDOW odometry messages; return the topics with a wrong
    rate.
    """
    for inbox in inboxes.values():
        inbox.payloads.clear()
    clock = inboxes["ROS 1", "/odom"].payloads
    await until(lambda: len(clock) > WINDOW, "the odometry")
    codec = STORE.codec("nav_msgs/Odometry")
    stamps_s = [codec.decode(payload).header.stamp.to_s() for payload in clock[: WINDOW + 1]]
    periods_s = [after - before for before, after in itertools.pairwise(stamps_s)]
    wrong = []
    if statistics.median(periods_s) != pytest.approx(1 / 30, abs=0.003):
        wrong.append(f"a period of {statistics.median(periods_s)} s")
    span_s = stamps_s[-1] - stamps_s[0]
    for (graph, topic), inbox in inboxes.items():
        hertz = SENT_HZ[topic][1]
        # The bridge itself publishes on /diagnostics too.
        count = sum(topic != "/diagnostics" or b"Analog Button" in payload for payload in inbox.payloads)
        # The simulated board shares the processor, so it misses some of 200 measurements a second.
        tolerance = 0.2 if hertz > 100 else 0.1
        if abs(count - span_s * hertz) > max(1.5, tolerance * span_s * hertz):
            wrong.append(f"{graph} {topic}: {count} messages in {span_s:.1f} s")
    return wrong


async def test_commands_of_both_graphs_are_obeyed(world: World) -> None:
    first, second = world.graphs["ROS 1"], world.graphs["ROS 2"]
    for commanding, watching in ((first, second), (second, first)):
        speed = await send(commanding, "/cmd_vel", watching, "/odom", linear={"x": 0.1})
        await speed(lambda odom: odom.twist.twist.linear.x > 0.09)
        power = await send(commanding, "/motor_power", watching, "/sensor_state", data=False)
        await power(lambda state: not state.torque)
        power = await send(commanding, "/motor_power", watching, "/sensor_state", data=True)
        await power(lambda state: state.torque)
        reset = await send(commanding, "/reset", watching, "/odom")
        await reset(lambda odom: odom.pose.pose.position.x == 0)
    sound = await second.advertise("/sound", STORE.registry.message_type(RECEIVED["/sound"]))
    await until(lambda: sound.subscriber_count)
    sound.publish_raw([b"\x04"])
    await world.bridge.wait_for("tone hertz=880", TIMEOUT_S)


async def send(
    commanding: Graph, topic: str, watching: Graph, answer: str, **fields: Any
) -> Callable[[Callable[[Any], object]], Any]:
    """Prepare a command in one graph; return a function that repeats it until the other graph shows its
    effect.
    """
    codec = STORE.codec(RECEIVED[topic])
    publisher = await commanding.advertise(topic, STORE.registry.message_type(RECEIVED[topic]))
    kind = SENT_HZ[answer][0]
    inbox = await listen(watching, answer, kind)
    await until(lambda: publisher.subscriber_count)

    async def repeat_until(condition: Callable[[Any], object]) -> None:
        def is_observed() -> bool:
            publisher.publish_raw([codec.encode(fields)])
            payloads, inbox.payloads = inbox.payloads, []
            return any(condition(STORE.codec(kind).decode(payload)) for payload in payloads)

        async with asyncio.timeout(TIMEOUT_S):
            while not is_observed():
                await until(lambda: inbox.payloads)

    return repeat_until
