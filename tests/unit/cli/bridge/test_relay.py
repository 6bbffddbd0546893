"""`rostether relay`: its arguments, and a relay between a real ROS 1 graph and another one."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from contract.graphs import SET_BOOL, STRING, TRUE, Inbox, answer, answer_set_bool, string
from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions, Middleware
from rostether.cli.bridge import relay as relay_command
from rostether.cli.bridge.relay import RelayOptions, finding_types, relay_between
from rostether.errors import UnknownTypeError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Graph
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.relay.relay_filter import RelayDirection, ServiceFilter, TopicFilter
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import join_ros1
from rostether.ros2.session import Ros2Access
from rostether.ros2.types.type_support import Ros2Types
from unit.cli.command_shell import Shell
from waiting import until


def test_what_is_typed() -> None:
    choice = RelayOptions(
        ("/chatter", "odom"), ("/sensors/*",), ("*",), ("/enable", "/plan=nav_msgs/GetPlan")
    ).choice()
    assert choice.topics == (
        TopicFilter("/chatter"),
        TopicFilter("/odom"),
        TopicFilter("/sensors/*", RelayDirection.FIRST_TO_SECOND),
        TopicFilter("*", RelayDirection.SECOND_TO_FIRST),
    )
    assert choice.services == (ServiceFilter("/enable"), ServiceFilter("/plan", "nav_msgs/GetPlan"))


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ([], 2, "give topics to relay"),
        (["/chatter", "--master", "http://localhost:1", "--master-port", "2"], 1, "--master joins a master"),
        (["bad name"], 1, "'bad name' is not a ROS name"),
        (["--service", "bad name=std_srvs/SetBool"], 1, "'bad name' is not a ROS name"),
    ],
)
def test_what_makes_no_sense_is_reported(shell: Shell, arguments: list[str], code: int, words: str) -> None:
    assert words in shell.failure("relay", *arguments, code=code)


async def test_types_of_services_are_found() -> None:
    types = Ros2Types(Registry(), Ros2Definitions())
    find = finding_types(types)
    for name in ("std_srvs/SetBool", "std_srvs/srv/SetBool"):
        assert (await find("/s", name)).md5sum == SET_BOOL.md5sum
    # One that only ROS 2 has.
    assert (await find("/s", "rcl_interfaces/srv/ListParameters")).name == "rcl_interfaces/ListParameters"
    assert (await find("/s", "rcl_interfaces/ListParameters")).name == "rcl_interfaces/ListParameters"
    for name in ("*", "std_srvs/srv/SetBool std_srvs/srv/Empty", "none/srv/Such"):
        with pytest.raises(UnknownTypeError):
            await find("/s", name)

    async def probe(service: str) -> str:
        assert service == "/s"
        return "std_srvs/SetBool"

    assert (await finding_types(types, probe)("/s", "*")).name == "std_srvs/SetBool"


async def test_an_unknown_type_of_a_service_is_reported_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    network = MemoryNetwork()

    @asynccontextmanager
    async def access(*_: Any, **__: Any) -> AsyncIterator[Ros2Access]:
        yield Ros2Access(network.join, Ros2Types(Registry(), Ros2Definitions()), "Joining a graph in memory")

    monkeypatch.setattr(relay_command, "ros2_access", access)
    master = await MasterServer.start(port=0)
    try:
        with pytest.raises(UnknownTypeError, match="foo/srv/Bar"):
            await relay_between(
                RosEnvironment.read({}).with_master(master.uri),
                GraphOptions(ros2=Middleware.ZENOH, master=master.uri),
                RelayOptions(services=("/x=foo/Bar",)).choice(),
                ConsoleReporter().report,
            )
    finally:
        await master.close()


async def test_a_relay(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    network = MemoryNetwork()

    @asynccontextmanager
    async def access(*_: Any, **__: Any) -> AsyncIterator[Ros2Access]:
        yield Ros2Access(network.join, Ros2Types(Registry(), Ros2Definitions()), "Joining a graph in memory")

    monkeypatch.setattr(relay_command, "ros2_access", access)
    master = await MasterServer.start(port=0)
    environment = RosEnvironment.read({}).with_master(master.uri)
    one = await join_ros1("/one", environment=environment)
    two = await network.join("/two")
    inboxes = Inbox(), Inbox()
    graphs: list[Graph] = [one, two]
    talkers = [await graph.advertise("/chatter", STRING) for graph in graphs]
    listeners = [
        await graph.subscribe("/chatter", STRING, inbox.store)
        for graph, inbox in zip(graphs, inboxes, strict=True)
    ]
    # A ROS 1 master does not know the types of services: the relay asks the server.
    await one.advertise_service("/switch", SET_BOOL, answer_set_bool)
    await two.advertise_service("/enable", SET_BOOL, answer_set_bool)
    choice = RelayOptions(("/chatter",), services=("/switch", "/enable")).choice()
    running = asyncio.ensure_future(
        relay_between(
            environment,
            GraphOptions(ros2=Middleware.ZENOH, master=master.uri),
            choice,
            ConsoleReporter().report,
        )
    )
    lines = ""

    def is_relaying() -> bool:
        nonlocal lines
        lines += capsys.readouterr().out
        return lines.count("relaying /chatter") == 2

    await until(is_relaying)
    # Each listener has two publishers: the talker of its graph, and the relay.
    await until(lambda: all(listener.publisher_count == 2 for listener in listeners))
    await until(lambda: all(talker.subscriber_count == 2 for talker in talkers))
    for number, talker in enumerate(talkers):
        talker.publish_raw([string(f"from {number}")])
    await until(lambda: all(len(inbox.payloads) == 2 for inbox in inboxes))
    await until(lambda: "/switch" in network.snapshot().services)
    assert await two.call_service("/switch", SET_BOOL, TRUE) == answer("done")
    while "/enable" not in (await one.snapshot()).services:
        await asyncio.sleep(0.01)
    assert await one.call_service("/enable", SET_BOOL, TRUE) == answer("done")
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    assert (await one.snapshot()).nodes == ("/one",)
    assert network.snapshot().nodes == ("/two",)
    lines += capsys.readouterr().out
    assert "Joining a graph in memory" in lines
    assert "relaying /chatter from ROS 1 to ROS 2 (std_msgs/String)" in lines
    assert "relaying service /switch from ROS 1 to ROS 2 (std_srvs/SetBool)" in lines
    for closing in (one, two, master):
        await closing.close()
