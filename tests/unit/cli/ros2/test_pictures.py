from __future__ import annotations

import re
from pathlib import Path

import pytest

from unit.cli.command_shell import Shell
from unit.cli.ros2.zenoh_world import ZenohWorld

pytestmark = pytest.mark.slow


def test_graph(world: ZenohWorld, shell: Shell, tmp_path: Path) -> None:
    assert shell.output("graph").splitlines() == [
        "/far/board",
        "  -> /imu [sensor_msgs/msg/Imu] to no node",
        "  -> /name [std_msgs/msg/String] to no node",
        "  <- /cmd_vel [geometry_msgs/msg/Twist] from no node",
        "  <- /goal [geometry_msgs/msg/Pose] from no node",
        "  => /set_led [std_srvs/srv/SetBool]",
    ]
    assert "/_raw" in shell.output("graph", "--all")
    file = tmp_path / "graph.svg"
    assert shell.output("graph", "--save", str(file)) == f"{file}: 1 node, 4 topics\n"
    assert "works on ROS 1 only; omit it" in shell.failure("graph", "--master", "http://x:1", code=2)


@pytest.mark.font
def test_plot(world: ZenohWorld, shell: Shell, tmp_path: Path) -> None:
    words = ("plot", "/imu/angular_velocity/z:x")
    printed = shell.observed("z 0.5 rad/s.*x 0 rad/s", *words).splitlines()
    assert printed[-2:] == ["── /imu/angular_velocity/z 0.5 rad/s", "── /imu/angular_velocity/x 0 rad/s"]
    file = tmp_path / "imu.png"
    reported = shell.observed("values", "plot", "/imu/linear_acceleration", "--save", str(file))
    assert re.fullmatch(re.escape(str(file)) + r": 3 curves, \d+ values\n", reported)
    assert file.read_bytes().startswith(b"\x89PNG")
