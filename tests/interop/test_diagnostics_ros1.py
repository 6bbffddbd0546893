"""/diagnostics of `rostether serve`, read by Debian's tools."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
import yaml

from interop.ros1_peers import Ros1Peers
from programs import started
from rostether import Device

OK, WARN, ERROR = 0, 1, 2

# The requirements of rqt_runtime_monitor and diagnostic_aggregator: each status has a name and a hardware_id,
# and no key occurs twice.
MONITOR = """
import sys, rospy
from diagnostic_msgs.msg import DiagnosticArray
rospy.init_node("py_monitor")
def handle(array):
    for status in array.status:
        assert array.header.stamp.to_sec() > 0
        assert all(each.key and isinstance(each.value, str) for each in status.values)
        assert len({each.key for each in status.values}) == len(status.values)
        print(status.name, "|", status.hardware_id, "|", status.level, "|", status.message, flush=True)
rospy.Subscriber("/diagnostics", DiagnosticArray, handle)
rospy.spin()
"""

SLOW_SKETCH = """
#include <ros.h>
#include <std_msgs/String.h>
ros::NodeHandle nh;
void handle(const std_msgs::String&) {}
ros::Subscriber<std_msgs::String> subscriber("words", &handle);
void setup() {
  nh.getHardware()->setBaud(9600);
  nh.initNode();
  nh.subscribe(subscriber);
}
void loop() { nh.spinOnce(); }
"""


async def echo_status(roscore: Ros1Peers) -> dict[str, Any]:
    """Return the output of `rostopic echo -n1 /diagnostics`."""
    text = await roscore.run("rostopic", "echo", "-n1", "/diagnostics")
    documents = [each for each in yaml.safe_load_all(text) if each]
    (array,) = documents
    (status,) = array["status"]
    assert array["header"]["stamp"]["secs"] > 0
    return dict(status)


def values(status: dict[str, Any]) -> dict[str, str]:
    return {each["key"]: each["value"] for each in status["values"]}


async def test_rostopic_echo_of_a_healthy_board(roscore: Ros1Peers, tmp_path: Path) -> None:
    port = tmp_path / "ttyACM0"
    async with Device(f"pty:{port}") as device:
        device.publisher("chatter", "std_msgs/String")
        async with started("serve", f"{port}?name=arm", ROS_MASTER_URI=roscore.master_uri) as serve:
            await serve.wait_for("Setup publisher on chatter")
            async with asyncio.timeout(60):
                # On a busy machine, a board may be late at first.
                while (status := await echo_status(roscore))["level"] != OK:
                    pass
            listed = await roscore.run("rostopic", "info", "/diagnostics")
    assert "Type: diagnostic_msgs/DiagnosticArray" in listed
    assert "* /arm (" in listed
    assert (status["name"], status["level"], status["message"]) == ("arm: rosserial", OK, "no problem found")
    assert status["hardware_id"] == str(port)
    found = values(status)
    assert found["state"] == "connected"
    assert found["publisher chatter type"] == "std_msgs/String"
    for key in ("frames", "checksum errors", "reconnects", "resets", "received [bytes]"):
        assert found[key].isdigit(), key


async def test_boards_are_distinguishable_in_monitors(roscore: Ros1Peers, tmp_path: Path) -> None:
    arm, base = tmp_path / "ttyACM0", tmp_path / "ttyACM1"
    monitor = await roscore.rospy(MONITOR)
    async with Device(f"pty:{base}") as base_device:
        base_device.publisher("odom", "nav_msgs/Odometry")
        async with Device(f"pty:{arm}") as arm_device:
            arm_device.publisher("chatter", "std_msgs/String")
            links = (f"{arm}?name=arm", f"{base}?name=base")
            serving = started("serve", *links, ROS_MASTER_URI=roscore.master_uri)
            serve = await serving.__aenter__()
            try:
                await monitor.wait_for(f"arm: rosserial | {arm} | {OK} | no problem found")
                await monitor.wait_for(f"base: rosserial | {base} | {OK} | no problem found")
                await arm_device.close()
                await monitor.wait_for(f"arm: rosserial | {arm} | {ERROR} | not connected")
                seen = len(monitor.lines)
                await monitor.wait_for(lambda lines: any("base: rosserial" in each for each in lines[seen:]))
            finally:
                await serving.__aexit__(None, None, None)
    assert "Traceback" not in monitor.text + serve.text


@pytest.mark.simavr
async def test_a_topic_with_more_data_than_the_line_carries(roscore: Ros1Peers, tmp_path: Path) -> None:
    sketch = tmp_path / "slow" / "slow.ino"
    sketch.parent.mkdir()
    sketch.write_text(SLOW_SKETCH)
    # A pseudo-terminal can pause the publisher, so only a limit of the queue makes it lose messages.
    settings = tmp_path / "devices.toml"
    settings.write_text('[devices.slow]\nqueue_depths = { "/words" = 10 }\n')
    link = f"sim:{sketch}?name=slow"
    async with started("serve", link, "--config", str(settings), ROS_MASTER_URI=roscore.master_uri) as serve:
        await serve.wait_for("Setup subscriber on words")
        await roscore.start("rostopic", "pub", "-r", "400", "/words", "std_msgs/String", "x" * 200)
        await serve.wait_for("dropping its oldest messages", timeout_s=60)
        async with asyncio.timeout(60):
            while (status := await echo_status(roscore))["level"] != WARN:
                pass
    finding = values(status)["finding messages-lost"]
    assert "words is faster than the board can receive" in finding
    assert int(values(status)["subscriber words dropped"]) > 0
    assert "publish it less often" in finding
