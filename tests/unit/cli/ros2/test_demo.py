from __future__ import annotations

import importlib.util
from contextlib import AsyncExitStack

import pytest

from programs import read_until, running
from rostether.cli.demo import setup
from rostether.cli.demo.view import RecentLines
from unit.cli.command_shell import LiveGraph, Shell
from unit.cli.ros2.zenoh_world import ZenohWorld

pytestmark = pytest.mark.slow


def test_the_demo_is_in_both_ros(graph: LiveGraph, world: ZenohWorld, shell: Shell) -> None:
    with running(
        "demo", "--board", "python", "--join", "--seconds", "170", ROS_MASTER_URI=graph.uri
    ) as process:
        lines = read_until(process, "virtual board ready")
        assert any("Joining ROS 2 domain 0 over zenoh" in line for line in lines)
        assert any("topic echo --ros2 zenoh /ultrasound" in line for line in lines)
        text = shell("topic", "echo", "--once", "/ultrasound").out
        assert "  frame_id: ultrasound\nradiation_type: 0\n" in text
        while "/set_led" not in shell.output("service", "list").splitlines():
            # Nodes discover a service shortly after its start.
            assert process.poll() is None
        call = shell.output("service", "call", "/set_led", "std_srvs/srv/SetBool", "{data: true}")
        assert "success=True" in call
        table = shell.output("monitor", "--once")
        assert table.splitlines()[1].split()[:2] == ["/virtual_board", "connected"]
        with running(
            "tf", "static", "--ros2", "zenoh", *["0", "0", "0.5", "0", "0", "0", "base_link", "mast"]
        ):
            pose = shell.output("tf", "echo", "-n", "1", "--timeout", "60", "base_link", "mast")
        assert "- Translation: [0.000, 0.000, 0.500]" in pose
        shell.output("tf", "echo", "-n", "1", "--timeout", "60", "odom", "base_link")
        assert "header" in shell("topic", "echo", "--ros1", "-n", "1", "/ultrasound").out


def test_the_demo_stays_in_ros1_on_request(graph: LiveGraph, world: ZenohWorld) -> None:
    with running(
        "demo",
        "--board",
        "python",
        "--join",
        "--ros1",
        "--seconds",
        "20",
        ROS_MASTER_URI=graph.uri,
    ) as process:
        lines = read_until(process, "virtual board ready")
    assert not any("ROS 2" in line for line in lines)


async def test_a_demo_without_zenoh_reports_the_missing_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(setup, "find_spec", lambda _: None)
    lines = RecentLines()
    async with AsyncExitStack() as stack:
        assert await setup.demo_ros2(stack, lines, joins=False) is None
    assert "pip install 'rostether[zenoh]'" in lines.lines[0]


@pytest.mark.skipif(importlib.util.find_spec("zenoh") is None, reason="zenoh is not installed")
async def test_a_demo_that_cannot_join_ros2_continues(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "900")
    lines = RecentLines()
    async with AsyncExitStack() as stack:
        assert await setup.demo_ros2(stack, lines, joins=False) is None
    assert "Not on ROS 2: ROS_DOMAIN_ID" in lines.lines[0]
