"""The platform's nodes as roles: sensing_manager, digital_tester and arduino_control."""

from __future__ import annotations

import os
from pathlib import Path

from rostether.cli.role.node import reporter, role
from rostether.graph.node_parameters import NodeParameters
from rostether.graph.typed_graph import TypedGraph
from rostether.names.remap import Arguments


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
    from rostether.platform.sensing_manager import SensingManager
    from rostether.platform.sensor_files import read_sensors_toml
    from rostether.ports.config_paths import sensors_path

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
    from rostether.platform.digital_tester import publish_test_values

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
    from rostether.platform.arduino_control import DEFAULT_DEADZONE, StickSettings, publish_commands

    parameters = NodeParameters(graph, "arduino_control/")
    settings = StickSettings(
        await parameters.number(DEFAULT_DEADZONE, "deadzone"), await parameters.text("reference", "formula")
    )
    await publish_commands(graph, settings, reporter(graph))
