"""`serial-node`: the arguments of serial_node.py, and its lines."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from contract.graphs import wait_for_snapshot
from programs import started
from rostether import Device
from rostether.cli.bridge.serial_node import choose_link
from rostether.errors import ConfigError
from rostether.joining import join
from rostether.ros1.master.server import MasterServer

pytestmark = pytest.mark.slow


def _link(*rest: str, options: str = "name=serial_node", **parameters: object) -> str:
    return choose_link(list(rest), parameters, options)


@pytest.mark.parametrize(
    ("link", "expected"),
    [
        (_link(), "/dev/ttyUSB0?name=serial_node"),
        (_link("/dev/ttyACM0"), "/dev/ttyACM0?name=serial_node"),
        (_link("/dev/ttyACM0", "115200"), "/dev/ttyACM0?name=serial_node&baud=115200"),
        (_link(port="/dev/ttyACM1", baud=115200), "/dev/ttyACM1?name=serial_node&baud=115200"),
        (_link("/dev/ttyACM0", port="/dev/ttyACM1"), "/dev/ttyACM0?name=serial_node"),
        (_link("/dev/ttyACM0?reset=no"), "/dev/ttyACM0?name=serial_node&reset=no"),
        (_link("tcp"), "tcp://:11411?name=serial_node"),
        (_link("tcp", "11412"), "tcp://:11412?name=serial_node"),
        (_link("tcp", tcp_port=11413), "tcp://:11413?name=serial_node"),
        (_link(port="tcp"), "tcp://:11411?name=serial_node"),
        (_link("tcp", options="name=arm&ns=/lab"), "tcp://:11411?name=arm&ns=/lab"),
    ],
)
def test_link(link: str, expected: str) -> None:
    assert link == expected


@pytest.mark.parametrize("baud", ["fast", "", True, -9600, 9.5, "9600²"])
def test_baud_that_is_not_a_number(baud: object) -> None:
    with pytest.raises(ConfigError, match="baud must be a whole number"):
        _link(baud=baud)


def test_a_port_that_yaml_reads_as_a_mapping() -> None:
    with pytest.raises(ConfigError, match=r"^port must be a serial port or tcp; write _port:=tcp or a path$"):
        _link(port={"tcp": None})


def test_too_many_arguments() -> None:
    with pytest.raises(ConfigError, match="unexpected argument"):
        _link("/dev/ttyACM0", "57600", "more")


@pytest.mark.parametrize(
    ("option", "advice"),
    [
        ("--master=http://127.0.0.1:1", "; write __master:=URI"),
        ("--baud", "; write _baud:=VALUE"),
        ("--tcp-port", "; write _tcp_port:=VALUE"),
        ("--name", "; write __name:=NAME"),
        ("--speed", "; see `rostether serial-node --help`"),
    ],
)
async def test_an_option_of_other_commands(option: str, advice: str) -> None:
    async with started("serial-node", "/dev/ttyACM0", option, "1") as command:
        text = await command.finish()
    assert text.strip().endswith(f"no such option {option}{advice}")


async def test_well_known_lines_over_a_pseudo_terminal(tmp_path: Path) -> None:
    master = await MasterServer.start(port=0)
    port = tmp_path / "ttyACM0"
    try:
        async with Device(f"pty:{port}") as device:
            device.publisher("chatter", "std_msgs/String")
            device.subscriber("led_out", "std_msgs/Byte", lambda _message: None)
            arguments = (f"_port:={port}", "_baud:=115200", "__name:=opencr", "chatter:=talk")
            async with started("serial-node", *arguments, ROS_MASTER_URI=master.uri) as node:
                await node.wait_for("Setup subscriber on led_out [std_msgs/Byte]")
                await node.wait_for("Setup publisher on chatter [std_msgs/String]")
                lines = [line.partition("]: ")[2] for line in node.lines]
                assert lines[0] == "ROS Serial Python Node"
                assert f"Connecting to {port} at 115200 baud" in lines
                assert any(line.startswith("Note: publish buffer size is ") for line in lines)
                assert all(line.startswith(("[INFO] [", "[WARN] [")) for line in node.lines)
                async with join("looker", environ={"ROS_MASTER_URI": master.uri}) as graph:
                    topics = (
                        await wait_for_snapshot(graph.raw, lambda found: "/talk" in found.topics)
                    ).topics
                assert topics["/talk"].publishers == ("/opencr",)
                assert "/chatter" not in topics
    finally:
        await master.close()


@pytest.mark.parametrize("mark", ["name", "port"])
async def test_settings_of_devices_toml(tmp_path: Path, mark: str) -> None:
    master = await MasterServer.start(port=0)
    port = tmp_path / "ttyACM0"
    table = (
        '[devices.serial_node]\nserial_number = "another"'
        if mark == "name"
        else f'[devices.arm]\nport = "{port}"'
    )
    config = tmp_path / "devices.toml"
    config.write_text(
        f"{table}\nbaud = 115200\n"
        'remap = { chatter = "/talk" }\nrequired_topics = ["imu"]\n'
        'access = { subscribe = { deny = ["/led_out"] } }\n'
    )
    environ = {"ROS_MASTER_URI": master.uri}
    try:
        async with Device(f"pty:{port}") as device:
            device.publisher("chatter", "std_msgs/String")
            device.subscriber("led_out", "std_msgs/Byte", lambda _message: None)
            async with started("serial-node", str(port), "--config", str(config), **environ) as node:
                await node.wait_for(f"Connecting to {port} at 115200 baud")
                await node.wait_for("may not subscribe to /led_out")
                await node.wait_for("does not announce imu, which devices.toml requires")
                async with join("looker", environ=environ) as graph:
                    topics = (
                        await wait_for_snapshot(graph.raw, lambda found: "/talk" in found.topics)
                    ).topics
                assert topics["/talk"].publishers == ("/serial_node",)
            async with started("serial-node", str(port), "57600", "--config", str(config), **environ) as node:
                await node.wait_for(f"Connecting to {port} at 57600 baud")
    finally:
        await master.close()


async def test_a_board_with_a_key_of_its_own(tmp_path: Path) -> None:
    master = await MasterServer.start(port=0)
    (tmp_path / "arm.key").write_text(f"{'5a' * 32}\n")
    (tmp_path / "arm.key").chmod(0o600)
    config = tmp_path / "devices.toml"
    config.write_text(f'[devices.serial_node]\npsk = "{tmp_path}/arm.key"\nremap = {{ chatter = "/talk" }}\n')
    words = ("serial-node", "tcp://127.0.0.1:0?psk=devices", "--config", str(config))
    try:
        async with started(*words, ROS_MASTER_URI=master.uri) as node:
            await node.wait_for("Waiting for boards on tcp://127.0.0.1:")
            port = node.text.rpartition(":")[2].split()[0]
            async with Device(f"tcp://127.0.0.1:{port}?psk={tmp_path}/arm.key") as device:
                device.publisher("chatter", "std_msgs/String")
                await node.wait_for("Setup publisher on chatter [std_msgs/String]")
                async with join("looker", environ={"ROS_MASTER_URI": master.uri}) as graph:
                    snapshot = await wait_for_snapshot(graph.raw, lambda found: "/talk" in found.topics)
                    assert snapshot.topics["/talk"].publishers == ("/serial_node",)
    finally:
        await master.close()


async def test_the_user_s_own_file_is_read_and_its_mistakes_are_reported(tmp_path: Path) -> None:
    config = tmp_path / "rostether" / "devices.toml"
    config.parent.mkdir()
    config.write_text("[devices.arm]\nbauds = 1\n")
    async with started("serial-node", "tcp", "0", XDG_CONFIG_HOME=str(tmp_path)) as node:
        assert await asyncio.wait_for(node.process.wait(), 60) == 1
        await node.wait_for("devices.toml:devices.arm.bauds: unknown key")


async def test_the_node_is_there_before_a_board_and_the_process_ends_with_it() -> None:
    master = await MasterServer.start(port=0)
    environ = {"ROS_MASTER_URI": master.uri}
    try:
        async with started("serial-node", "tcp", "0", **environ) as node:
            await node.wait_for("Waiting for boards on ")
            async with join("looker", environ=environ) as graph:
                assert "/serial_node" in (await graph.snapshot()).nodes
            async with join("serial_node", environ=environ) as graph:
                assert await asyncio.wait_for(node.process.wait(), 60) == 0
                assert (await graph.snapshot()).nodes.count("/serial_node") == 1
    finally:
        await master.close()


async def test_parameters_of_the_server(tmp_path: Path) -> None:
    master = await MasterServer.start(port=0)
    port = str(tmp_path / "nothing")
    master.api.parameters.set("/lab/opencr/port", port)
    try:
        arguments = ("__name:=opencr", "__ns:=lab")
        async with started("serial-node", *arguments, ROS_MASTER_URI=master.uri) as node:
            await node.wait_for(f"{port} does not exist; waiting until it is")
    finally:
        await master.close()


async def test_a_parameter_without_its_underscore_is_reported() -> None:
    master = await MasterServer.start(port=0)
    try:
        arguments = ("tcp", "0", "port:=/dev/ttyACM0")
        async with started("serial-node", *arguments, ROS_MASTER_URI=master.uri) as node:
            await node.wait_for("port:= remaps a topic; write _port:= to set the port")
    finally:
        await master.close()


async def test_unknown_private_parameter_is_reported() -> None:
    master = await MasterServer.start(port=0)
    try:
        async with started("serial-node", "tcp", "0", "_bauds:=1", ROS_MASTER_URI=master.uri) as node:
            await node.wait_for("unknown parameter _bauds")
    finally:
        await master.close()
