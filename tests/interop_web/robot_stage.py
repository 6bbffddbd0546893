"""A robot in a graph in memory, and a rosbridge server on it: what the web's clients are tested with."""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import AsyncIterator
from typing import Any

from rostether.errors import ServiceCallError
from rostether.gateways.rosbridge.rosapi.rosapi import Rosapi, offering_rosapi
from rostether.gateways.rosbridge.server import RosbridgeServer
from rostether.gateways.rosbridge.settings import RosbridgeSettings
from rostether.gateways.rosbridge.values import Style
from rostether.graph.memory_graph import MemoryGraph
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.values import Message

POSE = {
    "header": {"seq": 0, "stamp": Time(5, 6), "frame_id": "map"},
    "pose": {"position": {"x": 1.5, "y": -2.0, "z": 0.0}, "orientation": {"w": 1.0}},
}
POSE_JSON = {
    "header": {"seq": 0, "stamp": {"secs": 5, "nsecs": 6}, "frame_id": "map"},
    "pose": {
        "position": {"x": 1.5, "y": -2.0, "z": 0.0},
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
    },
}
SCAN = {"ranges": [math.nan, 1.0, math.inf, *([2.5] * 20_000)], "range_max": math.inf}
IMAGE_BYTES = 300_000


class RobotStage:
    """The graph, its talker, and what clients have published; `url` is where the server is."""

    def __init__(self, network: MemoryNetwork, talker: TypedGraph, gateway: MemoryGraph) -> None:
        self.network = network
        self.talker = talker
        self.received: dict[str, list[Message]] = {}
        self.api: Rosapi | None = None
        self._gateway = gateway
        self._server: RosbridgeServer | None = None
        self._port = 0
        self._tasks: list[asyncio.Task[None]] = []

    @property
    def url(self) -> str:
        """What clients connect to."""
        return f"ws://127.0.0.1:{self._port}"

    @property
    def port(self) -> int:
        """The server's port."""
        return self._port

    async def start_server(self) -> None:
        """Serve, the second time at the same port."""
        settings = RosbridgeSettings(host="127.0.0.1", port=self._port)
        store = self.talker.store
        self.api = Rosapi(self._gateway, store, style=Style.ROS1, settings=settings)
        self._server = RosbridgeServer(self._gateway, store, settings, local_services=self.api)
        await self._server.start()
        self._port = self._server.port

    async def stop_server(self) -> None:
        """Hang up on all clients."""
        if self._server is not None:
            await self._server.close()
            self._server = None

    def collect(self, topic: str, type_name: str) -> None:
        """Keep what is published on a topic in `received`."""
        messages = self.received.setdefault(topic, [])

        async def listen() -> None:
            async for message in self.talker.messages(topic, type_name):
                messages.append(message)

        self._tasks.append(asyncio.ensure_future(listen()))

    async def publish_regularly(
        self, topic: str, type_name: str, value: dict[str, Any], period_s: float
    ) -> None:
        """Publish a message again and again until the stage is left."""
        publisher = await self.talker.publisher(topic, type_name)
        payload = publisher.codec.encode(value)

        async def run() -> None:
            while True:
                publisher.raw.publish_raw([payload])
                await asyncio.sleep(period_s)

        self._tasks.append(asyncio.ensure_future(run()))

    async def close(self) -> None:
        """End everything."""
        await self.stop_server()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)


@contextlib.asynccontextmanager
async def robot_stage() -> AsyncIterator[RobotStage]:
    """Set everything up for as long as the block lasts."""
    network = MemoryNetwork()
    store = TypeStore(Registry())
    talker = TypedGraph(await network.join("/talker"), store)
    gateway = await network.join("/gateway")
    stage = RobotStage(network, talker, gateway)
    try:
        latched = await talker.publisher("/latched", "std_msgs/String", latch=True)
        latched.publish(data="kept")
        await stage.publish_regularly("/pose", "geometry_msgs/PoseStamped", POSE, 0.02)
        await stage.publish_regularly("/scan", "sensor_msgs/LaserScan", SCAN, 0.2)
        image = {"header": {"frame_id": "camera"}, "data": (bytes(range(256)) * 1200)[:IMAGE_BYTES]}
        await stage.publish_regularly("/image", "sensor_msgs/Image", image, 0.2)
        await stage.publish_regularly("/fast", "std_msgs/UInt32", {"data": 7}, 0.005)
        await talker.serve("/enable", "std_srvs/SetBool", _enable)
        await talker.serve("/fail", "std_srvs/Trigger", _fail)
        await _serve_action(stage)
        await stage.start_server()
        assert stage.api is not None
        async with offering_rosapi(stage.api, network.join, gateway):
            yield stage
    finally:
        await stage.close()
        for graph in list(network.nodes.values()):
            await graph.close()


def _enable(request: Message) -> dict[str, Any]:
    return {"success": request.data, "message": "enabled"}


def _fail(_: Message) -> dict[str, Any]:
    raise ServiceCallError("the motor is missing")


async def _serve_action(stage: RobotStage) -> None:
    """Answer every goal of the action /lookup at once, as an actionlib server would."""
    action = "tf2_msgs/LookupTransformAction"
    talker = stage.talker
    results = await talker.publisher("/lookup/result", f"{action}Result")
    await talker.publisher("/lookup/feedback", f"{action}Feedback")
    statuses = await talker.publisher("/lookup/status", "actionlib_msgs/GoalStatusArray")
    await stage.publish_regularly("/lookup/status", "actionlib_msgs/GoalStatusArray", {}, 0.2)

    async def answer() -> None:
        async for goal in talker.messages("/lookup/goal", f"{action}Goal"):
            status = {"goal_id": goal.goal_id, "status": 3}
            statuses.publish(status_list=[status])
            text = f"{goal.goal.source_frame} to {goal.goal.target_frame}"
            results.publish(status=status, result={"error": {"error_string": text}})

    stage.collect("/lookup/cancel", "actionlib_msgs/GoalID")
    stage._tasks.append(asyncio.ensure_future(answer()))
