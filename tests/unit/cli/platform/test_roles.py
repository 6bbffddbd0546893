"""The platform's nodes as `rostether run` starts them."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from programs import started
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.joining import join
from rostether.ros1.master.server import MasterServer
from unit.platform.datagrams import loopback_group
from waiting import until

pytestmark = pytest.mark.slow


@pytest_asyncio.fixture
async def master() -> AsyncIterator[MasterServer]:
    master = await MasterServer.start(port=0)
    try:
        yield master
    finally:
        await master.close()


@pytest_asyncio.fixture
async def graph(master: MasterServer) -> AsyncIterator[TypedGraph]:
    async with join("test", environ={"ROS_MASTER_URI": master.uri}) as graph:
        yield graph


async def test_arduino_control(master: MasterServer, graph: TypedGraph) -> None:
    joy = await graph.publisher("/joy", "sensor_msgs/Joy")
    # The parameter has the name that the node of the reference reads.
    await graph.set_param("/arduino_control/deadzone", 0.01)
    async with started("run", "arduino_control", "arduino_control", ROS_MASTER_URI=master.uri):
        async with asyncio.timeout(60):
            publishing = asyncio.ensure_future(repeat(joy, axes=[0.05, 0.0]))
            async for command in graph.messages("/arduino_control"):
                assert 0.0499 < command.speed < 0.0501
                break
            publishing.cancel()


async def test_a_parameter_that_is_not_a_number(master: MasterServer) -> None:
    async with started("role", "arduino-control", "_deadzone:=wide", ROS_MASTER_URI=master.uri) as node:
        assert await asyncio.wait_for(node.process.wait(), 60) == 1
        await node.wait_for("rostether: error: ~deadzone must be a number, not 'wide'")


async def test_an_option_that_a_node_does_not_have(master: MasterServer) -> None:
    words = ("camera", "--source", "test", "_rate:=0")
    async with started("role", *words, ROS_MASTER_URI=master.uri) as node:
        await node.wait_for("WARNING: ignored '--source'; a node's parameters are written _name:=value")
        await node.wait_for("~rate must be above 0")


async def test_parameters_that_a_node_does_not_have(master: MasterServer) -> None:
    words = ("topic:=/cmd_vel", "_frequnecy:=5", "_mulicast_group_addr:=239.255.82.83", "_interface:=lo")
    async with started("role", "multicast-topic-bridge", *words, ROS_MASTER_URI=master.uri) as node:
        await node.wait_for(
            "WARNING: 'topic:=/cmd_vel' renames a topic; the parameter is written _topic:=value"
        )
        await node.wait_for("WARNING: this node has no parameter _frequnecy; did you mean _frequency?")
        await node.wait_for("sending /multicast_topic to 239.255.82.83:12345")
        assert "_mulicast_group_addr" not in node.text


async def test_a_topic_over_multicast_and_back(
    master: MasterServer, graph: TypedGraph, tmp_path: Path
) -> None:
    address = loopback_group()
    key = tmp_path / "fleet.key"
    key.write_text("00112233445566778899aabbccddeeff\n")
    both = ("_interface:=lo", f"_sending_port:={address.port}", "_framed:=true", f"_key_file:={key}")
    # The address has the spelling of the reference's document, and of its code.
    sending = ("run", "bridge", "multicast_topic_bridge", "_topic:=/arduino_control", *both)
    receiving = ("run", "bridge", "multicast_topic_receiver", "_topic:=/robot_3/control", *both)
    environ = {"ROS_MASTER_URI": master.uri}
    await graph.set_param("/multicast_topic_receiver/type", "arduino_control/ArduinoControl")
    control = await graph.publisher("/arduino_control", "arduino_control/ArduinoControl")
    async with (
        started(*receiving, f"_mulicast_group_addr:={address.group}", **environ) as receiver,
        started(*sending, f"_multicating_group_addr:={address.group}", **environ) as bridge,
    ):
        await receiver.wait_for("receiving arduino_control/ArduinoControl from 239.255.82.83:")
        await bridge.wait_for("sending /arduino_control to 239.255.82.83:")
        async with asyncio.timeout(60):
            publishing = asyncio.ensure_future(repeat(control, dir=90.0, speed=0.5))
            async for command in graph.messages("/robot_3/control"):
                # Once the topic is silent, the robot is stopped; on a busy machine, it may be before.
                assert command.speed in (0.5, 0.0)
                if command.speed:
                    publishing.cancel()
                elif publishing.cancelled():
                    break


async def repeat(publisher: TypedPublisher[...], **fields: object) -> None:
    while True:
        publisher.publish(**fields)
        await asyncio.sleep(0.05)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("multicast-topic-receiver",), "give the type of the messages, for instance _type:="),
        (("multicast-topic-receiver", "_type:=no/Such"), "no/Such"),
        (
            ("multicast-topic-bridge", "_sending_port:=0"),
            "~sending_port must be a whole number from 1 to 65535",
        ),
        (
            ("multicast-topic-bridge", "_framed:=true", "_key_file:=none"),
            "the fleet's key: cannot read none:",
        ),
        (("multicast-topic-bridge", "_framed:=true", "_robot:=1", "_groups:=2"), "give ~robot or ~groups"),
        (("digital",), "give one of ~gpio, ~path or ~topic, for instance _topic:="),
        (("multicast-topic-bridge", "_framed:=1"), "~framed must be true or false, not 1"),
    ],
)
async def test_what_is_typed_wrong(master: MasterServer, words: tuple[str, ...], reason: str) -> None:
    async with started("role", *words, ROS_MASTER_URI=master.uri) as command:
        assert await asyncio.wait_for(command.process.wait(), 60) == 1
        await command.wait_for(reason)


async def test_sensors_and_their_commands(master: MasterServer, graph: TypedGraph, tmp_path: Path) -> None:
    environ = {"ROS_MASTER_URI": master.uri, "XDG_STATE_HOME": str(tmp_path)}
    sensors_file = tmp_path / "sensors.toml"
    sensors_file.write_text('"/arm/ultrasound" = { name = "Distance", unit = "m" }\n')

    async def typed(*words: str, code: int = 0) -> list[str]:
        async with started("sensor", *words, **environ) as command:
            assert await asyncio.wait_for(command.process.wait(), 60) == code
            await until(lambda: command.reader_done)
            return list(command.lines)

    testing = ("run", "sensors", "digital_tester.py")
    managing = ("run", "sensors", "sensing_manager.py", f"_sensors_file:={sensors_file}")
    async with started(*testing, **environ, PLATFORM_NAME="Robot3") as tester:
        async with started(*managing, **environ):
            await tester.wait_for("registered for topic sensor_node0")
            assert (await graph.wait_for_message("/sensor_node0", timeout_s=60)).data in range(101)
            assert await typed("rename", "sensor_node0", "Test value") == ["sensor_node0: Test value"]
            (refused,) = await typed("rename", "Distance", "Range", code=1)
            assert "the name of arm/ultrasound is set in sensors.toml; change it there" in refused
        async with started(*managing, **environ) as manager:
            await manager.wait_for("sensors known from an earlier run: 1")
            async with asyncio.timeout(60):
                async for message in graph.messages("/sensors", "sensing_platform/Sensors"):
                    if [each.state for each in message.sensors] == ["ready", "init"]:
                        break
            shown = [
                "Robot3",
                "  sensor_node0  DIGITAL  ready  /sensor_node0  Test value",
                "arm",
                "  arm/ultrasound  ANALOG  init  /arm/ultrasound  Distance",
            ]
            async with asyncio.timeout(60):
                # On a busy machine the sensor may be silent for a moment.
                while await typed("list") != shown:
                    pass
            shown = await typed("show", "Test value")
            assert shown[:4] == [
                "id: sensor_node0",
                "name: Test value",
                "platform: Robot3",
                "sensor type: DIGITAL",
            ]
            assert json.loads((await typed("list", "--json"))[1])["unit"] == "m"
            assert "no sensor has the id or the name 'x'" in (await typed("show", "x", code=1))[0]
