"""rosserial_python in a script: the board's topics belong to the script's own node."""

from __future__ import annotations

import asyncio
from pathlib import Path

from rostether.device.device import Device
from rostether.ros1.master.server import MasterServer
from unit.rospy.programs import line_of, running_script

# Users write variants of serial_node.py like this.
SCRIPT = """
import rospy
from rosserial_python import RosSerialServer, SerialClient
from rostether.rospy.client import serial_client
from std_msgs.msg import String

# Boards are slow on a busy machine.
serial_client._SHUTDOWN_LIMIT_S = 60

def hear(message):
    print("heard", message.data)
    rospy.signal_shutdown("heard")

rospy.init_node("host")
rospy.Subscriber("host/said", String, hear)
port = rospy.myargv()[1]
print("ready")
SerialClient(port, 115200).run()
print("left", rospy.is_shutdown())
"""


async def test_a_board_is_served_by_the_scripts_node(tmp_path: Path) -> None:
    master = await MasterServer.start(port=0)
    port = tmp_path / "board"
    try:
        async with Device(f"pty:{port}") as device:
            reported = device.publisher("~said", "std_msgs/String")
            async with running_script(SCRIPT, str(port), master_uri=master.uri) as script:
                await line_of(script, "ready")
                await device.wait_connected(60)

                async def say() -> None:
                    while True:
                        reported.publish(data="hello")
                        await asyncio.sleep(0.05)

                saying = asyncio.create_task(say())
                try:
                    assert await line_of(script, "heard") == "heard hello"
                finally:
                    saying.cancel()
                assert await line_of(script, "left") == "left True"
                assert await asyncio.wait_for(script.wait(), 60) == 0
    finally:
        await master.close()
