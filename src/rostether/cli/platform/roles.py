"""The platform's nodes as roles: sensing, tests, joystick commands, multicast and the fleet's monitor."""

from __future__ import annotations

import os
from pathlib import Path

from rostether.cli.platform.fleet_options import MAX_ROBOT, group_mask
from rostether.cli.role.node import reporter, role
from rostether.errors import ConfigError
from rostether.graph.node_parameters import NodeParameters
from rostether.graph.typed_graph import TypedGraph
from rostether.names.remap import Arguments
from rostether.platform.arduino_control import DEFAULT_DEADZONE, StickSettings, publish_commands
from rostether.platform.boot.robot_file import INTERFACE_VARIABLE
from rostether.platform.command_frame import ALL_GROUPS, DEFAULT_TTL_MS, MAX_TTL_MS, NO_KEY, type_kind
from rostether.platform.command_link import ReceiverSettings, SenderSettings
from rostether.platform.digital_tester import publish_test_values
from rostether.platform.fleet import FleetSettings
from rostether.platform.fleet_key import read_fleet_key
from rostether.platform.fleet_monitor import FleetMonitor
from rostether.platform.multicast_bridge import BridgeNodeSettings, send_topic
from rostether.platform.multicast_receiver import ReceiverNodeSettings, receive_topic
from rostether.platform.multicast_socket import GroupAddress
from rostether.platform.sensing_manager import SensingManager
from rostether.platform.sensor_files import read_sensors_toml
from rostether.ports.config_paths import sensors_path

# The nodes of the reference platform spell this parameter in three ways.
_ADDRESS_NAMES = ("multicast_group_addr", "mulicast_group_addr", "multicating_group_addr")


@role(
    "sensing-manager",
    """
    rostether role sensing-manager
    rostether role sensing-manager _sensors_file:=sensors.toml
    """,
    has_ros2=True,
)
async def sensing_manager(graph: TypedGraph, _: Arguments) -> None:
    """Register sensors (service `sensors_register`), watch them and publish their list (`sensors`).

    Parameters: ~sensors_file (topics of boards that are sensors, one per line), ~state_file (where registered
    sensors are kept across restarts; default: ~/.local/state/rostether/sensors.json).
    """
    parameters = NodeParameters(graph, "sensing_manager/")
    state_file = await parameters.text("", "state_file")
    sensors_file = await parameters.text("", "sensors_file")
    manager = SensingManager(
        graph,
        reporter(graph),
        state_path=_path(state_file) if state_file else sensors_path(),
        named=read_sensors_toml(_path(sensors_file)) if sensors_file else (),
    )
    await manager.run()


@role(
    "digital-tester",
    """
    rostether role digital-tester
    rostether role digital-tester _platform_name:=Robot3 __name:=tester_3
    """,
    has_ros2=True,
)
async def digital_tester(graph: TypedGraph, _: Arguments) -> None:
    """Publish a random number from 0 to 100 each second, as a test sensor.

    Its platform is ~platform_name, else the variable PLATFORM_NAME, else DigitalTesterStation.
    """
    default = os.environ.get("PLATFORM_NAME") or "DigitalTesterStation"
    # The node of the reference platform reads the parameter node/platform_name.
    fallback = await NodeParameters(graph, "node/").text(default, "platform_name")
    platform = await NodeParameters(graph, "digital_tester/").text(fallback, "platform_name")
    await publish_test_values(graph, platform, reporter(graph))


def _path(text: str) -> Path:
    return Path(text).expanduser()


@role(
    "arduino-control",
    """
    rostether role arduino-control
    rostether role arduino-control _formula:=radial _deadzone:=0.15 joy:=/robot_3/joy
    """,
    has_ros2=True,
)
async def arduino_control(graph: TypedGraph, _: Arguments) -> None:
    """Turn a joystick's axes (`joy`) into commands for a robot (`arduino_control`).

    Parameters: ~deadzone (0.1), ~formula (reference). With ~formula radial, the speed grows smoothly from the
    edge of the dead zone to at most 1 in every direction; with reference, it reaches 1.414 in the corners.
    """
    parameters = NodeParameters(graph, "arduino_control/")
    settings = StickSettings(
        await parameters.number(DEFAULT_DEADZONE, "deadzone"), await parameters.text("reference", "formula")
    )
    await publish_commands(graph, settings, reporter(graph))


@role(
    "multicast-topic-bridge",
    """
    rostether role multicast-topic-bridge _topic:=arduino_control
    rostether role multicast-topic-bridge _topic:=arduino_control _frequency:=0 _interface:=wlan0
    rostether role multicast-topic-bridge _topic:=cmd_vel _framed:=true _robot:=3 _key_file:=fleet.key
    """,
    has_ros2=True,
)
async def multicast_topic_bridge(graph: TypedGraph, _: Arguments) -> None:
    """Send the newest message of a topic to a multicast group, one message per datagram.

    Parameters: ~topic (multicast_topic), ~multicast_group_addr (224.0.1.1; the spellings
    ~mulicast_group_addr and ~multicating_group_addr also work), ~sending_port (12345), ~frequency (1000 Hz; 0
    sends immediately), ~interface (names or addresses), ~ttl (1). With ~framed true, the group is that of
    `rostether fleet` (239.255.82.83, port 11412), and robots check which sender commands them: ~robot (an id)
    or ~groups (all), ~key_file, ~ttl_ms (300), ~input_timeout (0.5 s), ~unicast (addresses of robots that
    multicast does not reach).
    """
    parameters = NodeParameters(graph, "multicast_topic_bridge/")
    framed = None
    if await parameters.flag(False, "framed"):
        robot = await parameters.integer(0, 0, MAX_ROBOT, "robot")
        groups = await _group_mask(parameters)
        if robot and groups:
            raise ConfigError(
                "give ~robot or ~groups, not both; a ROS master keeps the parameters of earlier runs, and "
                "`rostether param delete` deletes them"
            )
        framed = SenderSettings(
            robot or groups or ALL_GROUPS,
            to_groups=not robot,
            ttl_ms=await parameters.integer(DEFAULT_TTL_MS, 1, MAX_TTL_MS, "ttl_ms"),
            key=await _key(parameters),
        )
    settings = BridgeNodeSettings(
        topic=await parameters.text("multicast_topic", "topic"),
        address=await _address(parameters, _default_address(framed), "sending_port"),
        frequency_hz=await parameters.number(1000.0, "frequency"),
        framed=framed,
        input_timeout_s=await parameters.number(0.5, "input_timeout"),
        unicast=await parameters.texts("unicast"),
    )
    await send_topic(graph.raw, settings, reporter(graph))


@role(
    "multicast-topic-receiver",
    """
    rostether role multicast-topic-receiver _topic:=arduino_control _type:=arduino_control/ArduinoControl
    rostether role multicast-topic-receiver _topic:=cmd_vel _type:=geometry_msgs/Twist _framed:=true _robot:=3
    """,
    has_ros2=True,
)
async def multicast_topic_receiver(graph: TypedGraph, _: Arguments) -> None:
    """Publish the messages that arrive from a multicast group.

    Parameters: ~topic (multicast_topic), ~type, ~multicast_group_addr (224.0.1.1; the spellings
    ~mulicast_group_addr and ~multicating_group_addr also work), ~receiving_port or ~sending_port (12345),
    ~interface, ~sources (networks that may send; default: this machine). With ~framed true, the group is that
    of `rostether fleet` (239.255.82.83, port 11412); only commands for this robot are published, and zeros
    when they end: ~robot (1), ~groups (0), ~key_file.
    """
    parameters = NodeParameters(graph, "multicast_topic_receiver/")
    type_name = await parameters.text("", "type")
    if not type_name:
        raise ConfigError("give the type of the messages, for instance _type:=arduino_control/ArduinoControl")
    framed = None
    if await parameters.flag(False, "framed"):
        kind = type_kind(graph.store.registry.message_type(type_name).md5sum)
        robot = await parameters.integer(1, 1, MAX_ROBOT, "robot")
        framed = ReceiverSettings(robot, await _group_mask(parameters) or 1, kind, await _key(parameters))
    settings = ReceiverNodeSettings(
        type_name,
        topic=await parameters.text("multicast_topic", "topic"),
        address=await _address(parameters, _default_address(framed), "receiving_port", "sending_port"),
        sources=await parameters.texts("sources"),
        framed=framed,
        has_key=framed is not None and any(framed.key),
    )
    await receive_topic(graph, settings, reporter(graph))


@role(
    "fleet-monitor",
    """
    rostether role fleet-monitor _key_file:=fleet.key
    rostether role fleet-monitor _interface:=wlan0 _key_file:=fleet.key
    """,
    has_ros2=True,
)
async def fleet_monitor(graph: TypedGraph, _: Arguments) -> None:
    """Publish the state of each robot (`fleet`), and stop robots (service `fleet_stop`).

    Parameters: ~multicast_group_addr (239.255.82.83), ~sending_port (11412), ~interface (names or addresses),
    ~ttl (1), ~groups (all), ~key_file, ~unicast (addresses of robots that multicast does not reach).
    """
    parameters = NodeParameters(graph, "fleet_monitor/")
    settings = FleetSettings(
        SenderSettings(await _group_mask(parameters) or ALL_GROUPS, key=await _key(parameters)),
        await _address(parameters, FleetSettings().address, "sending_port"),
        await parameters.texts("unicast"),
    )
    await FleetMonitor(graph, settings, reporter(graph)).run()


def _default_address(framed: object | None) -> GroupAddress:
    return GroupAddress() if framed is None else FleetSettings().address


async def _address(parameters: NodeParameters, default: GroupAddress, *port_names: str) -> GroupAddress:
    return GroupAddress(
        await parameters.text(default.group, *_ADDRESS_NAMES),
        await parameters.integer(default.port, 1, 65535, *port_names),
        await parameters.texts("interface") or tuple(os.environ.get(INTERFACE_VARIABLE, "").split()),
        await parameters.integer(1, 0, 255, "ttl"),
    )


async def _group_mask(parameters: NodeParameters) -> int:
    return group_mask(await parameters.texts("groups"), "~groups")


async def _key(parameters: NodeParameters) -> bytes:
    path = await parameters.text("", "key_file")
    return read_fleet_key(path) if path else NO_KEY
