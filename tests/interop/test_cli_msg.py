"""`rostether msg` and `rostether srv` compared with rosmsg and rossrv."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from interop.ros1_peers import Ros1Peers
from interop.side_by_side import SideBySide
from rostether.cli.msg.group import format_spec
from rostether.msgdef.registry import Registry

# The output of rosmsg and rossrv for every type, without starting them a thousand times.
SHOW_ALL = """
import json, rosmsg, rospkg
packages = rospkg.RosPack()
shown = {"msg": {}, "srv": {}}
for kind, mode, text_of in (
    ("msg", rosmsg.MODE_MSG, rosmsg.get_msg_text), ("srv", rosmsg.MODE_SRV, rosmsg.get_srv_text)
):
    for package, _ in rosmsg.iterate_packages(packages, mode):
        for name in rosmsg.list_types(package, mode=mode, rospack=packages):
            shown[kind][name] = text_of(name, rospack=packages)
print(json.dumps(shown))
"""


@pytest.fixture
def peers(tmp_path: Path) -> Ros1Peers:
    """Debian's programs, without a master, which definitions do not need."""
    return Ros1Peers("http://localhost:9/", tmp_path)


async def test_all_types_have_the_same_text(peers: Ros1Peers) -> None:
    shown = json.loads(await peers.run("python", "-c", SHOW_ALL, timeout_s=60))
    registry = Registry(package_path=[Path("/usr/share")])
    assert {"sensor_msgs/PointCloud2", "rosgraph_msgs/Log"} <= shown["msg"].keys()
    assert {"sensor_msgs/SetCameraInfo", "std_srvs/Empty"} <= shown["srv"].keys()

    def lines(*specs: str) -> str:
        return "".join(
            f"{line}\n" for each in specs for line in format_spec(registry, registry.message(each))
        )

    for name, text in shown["msg"].items():
        assert lines(name) == text
    for name, text in shown["srv"].items():
        assert f"{lines(f'{name}Request')}---\n{lines(f'{name}Response')}" == text
    assert set(shown["msg"]) <= set(registry.messages())
    assert set(shown["srv"]) <= set(registry.services())


async def test_the_commands_print_the_same(peers: Ros1Peers) -> None:
    tools = SideBySide(peers)
    await tools.assert_all_same(
        "rosmsg",
        ("show", "sensor_msgs/Imu"),
        ("show", "-r", "sensor_msgs/BatteryState"),
        ("info", "geometry_msgs/Twist.msg"),
        ("md5", "sensor_msgs/Imu"),
        ("package", "-s", "geometry_msgs"),
    )
    await tools.assert_all_same(
        "rossrv",
        ("show", "-r", "sensor_msgs/SetCameraInfo"),
        ("show", "SetBool"),
        ("md5", "std_srvs/SetBool"),
        ("package", "std_srvs"),
    )
    assert (
        await tools.assert_same("rosmsg", "md5", stdin="std_msgs/String\n")
        == "992ce8a1687cec8c8bd883ec73ca41d1\n"
    )
    listed = (await tools.run_rostether("rosmsg", "list")).out.splitlines()
    assert set((await tools.run_debian("rosmsg", "list")).out.splitlines()) <= set(listed)
    assert "std_msgs/String" in await tools.assert_both_fail("rosmsg", "show", "std_msgs/Strng")
    await tools.assert_both_fail("rosmsg", "show", "NoSuchMessage")
    await tools.assert_both_fail("rosmsg", "package", "no_such_package")
