"""`rostether rosbridge` on a ROS 2 graph."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect

from programs import started
from unit.cli.ros2.zenoh_world import ZenohWorld

pytestmark = pytest.mark.slow


async def received(client: ClientConnection, op: str, topic: str | None = None) -> dict[str, Any]:
    """Return the next message with this operation; others of a topic may come after its end."""
    while True:
        message: dict[str, Any] = json.loads(await client.recv())
        if message["op"] == op and message.get("topic") == topic:
            return message


async def test_pages_get_the_names_of_ros2(world: ZenohWorld) -> None:
    async with started("rosbridge", "0", "--ros2", "zenoh") as gateway:
        await gateway.wait_for("allows other machines")
        match = re.search(r"connect to (ws://localhost:\d+)", gateway.text)
        assert match is not None, gateway.text
        async with connect(match[1]) as client:
            await client.send('{"op": "subscribe", "topic": "/imu", "type": "sensor_msgs/msg/Imu"}')
            imu = (await received(client, "publish", "/imu"))["msg"]
            assert imu["header"] == {"stamp": {"sec": 5, "nanosec": 7}, "frame_id": "base"}
            await client.send('{"op": "unsubscribe", "topic": "/imu"}')
            await client.send('{"op": "subscribe", "topic": "/name"}')
            assert (await received(client, "publish", "/name"))["msg"] == {"data": "arm"}
            await client.send('{"op": "call_service", "service": "/set_led", "args": {"data": true}}')
            answer = await received(client, "service_response")
            assert answer["values"] == {"success": True, "message": "it is on"}
            twist = {"linear": {"x": 0.5}}
            await client.send(
                json.dumps({"op": "advertise", "topic": "/cmd_vel", "type": "geometry_msgs/msg/Twist"})
            )
            await client.send(json.dumps({"op": "publish", "topic": "/cmd_vel", "msg": twist}))
            await client.send('{"op": "call_service", "service": "/rosapi/topic_type", "args": ["/imu"]}')
            assert (await received(client, "service_response"))["values"] == {"type": "sensor_msgs/msg/Imu"}
            world.wait_until(lambda: len(world.received) == 1)
