"""rosserial_python in a script: the board's topics belong to the script's own node."""

from __future__ import annotations

import asyncio
from pathlib import Path

from rostether.device.device import Device
from rostether.mechanisms.block_end import task_beside
from unit.rospy.programs import line_of, running_script

# Users write variants of serial_node.py like this.
SCRIPT = """
import rospy
from rosserial_python import RosSerialServer, SerialClient
from rostether.rospy.client import serial_client
from std_msgs.msg import String

# Boards are slow on a busy machine.
serial_client._SHUTDOWN_LIMIT_S = 60

def receive(message):
    print("received", message.data)
    rospy.signal_shutdown("received")

rospy.init_node("host")
rospy.Subscriber("host/chatter", String, receive)
port = rospy.myargv()[1]
print("ready")
SerialClient(port, 115200).run()
print("left", rospy.is_shutdown())
"""


async def test_a_board_is_served_by_the_scripts_node(master: str, tmp_path: Path) -> None:
    port = tmp_path / "board"
    async with Device(f"pty:{port}") as device:
        publisher = device.publisher("~chatter", "std_msgs/String")

        async def publish() -> None:
            while True:
                publisher.publish(data="hello")
                await asyncio.sleep(0.05)

        async with running_script(SCRIPT, str(port), master_uri=master) as script:
            await line_of(script, "ready")
            await device.wait_connected(60)
            async with task_beside(publish()):
                assert await line_of(script, "received") == "received hello"
            assert await line_of(script, "left") == "left True"
            assert await asyncio.wait_for(script.wait(), 60) == 0
