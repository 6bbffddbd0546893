"""A robot in a graph and a rosbridge server, for the tests of web clients."""

from __future__ import annotations

import asyncio
import contextlib
import math
from base64 import b64encode
from collections.abc import AsyncIterator
from typing import Any

from interop_web.graphs import WebGraph
from rostether.errors import ServiceCallError
from rostether.gateways.rosbridge.form_source import Style
from rostether.gateways.rosbridge.rosapi.rosapi import Rosapi, offering_rosapi
from rostether.gateways.rosbridge.server import RosbridgeServer
from rostether.gateways.rosbridge.settings import RosbridgeSettings
from rostether.gateways.rosbridge.values import JsonForm
from rostether.graph.ports import Graph
from rostether.graph.typed_graph import TypedGraph
from rostether.rostime import Time
from rostether.serde.values import Message

_POSE = {
    "position": {"x": 1.5, "y": -2.0, "z": 0.0},
    "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
}
POSE = {
    Style.ROS1: {"header": {"seq": 0, "stamp": {"secs": 5, "nsecs": 6}, "frame_id": "map"}, "pose": _POSE},
    Style.ROS2: {"header": {"stamp": {"sec": 5, "nanosec": 6}, "frame_id": "map"}, "pose": _POSE},
}
SCAN = {"ranges": [None, 1.0, math.inf, *([2.5] * 20_000)], "range_max": math.inf}
IMAGE_BYTES = 300_000


class RobotStage:
    """The graph, its talker, and the messages that clients have published; `url` is the server's address."""

    def __init__(self, graph: WebGraph, talker: TypedGraph, gateway: Graph) -> None:
        self.graph = graph
        self.talker = talker
        self.received: dict[str, list[Message]] = {}
        self.api: Rosapi | None = None
        self._gateway = gateway
        self._server: RosbridgeServer | None = None
        self._port = 0
        self._tasks: list[asyncio.Task[None]] = []

    @property
    def url(self) -> str:
        """The address for clients."""
        return f"ws://127.0.0.1:{self._port}"

    @property
    def port(self) -> int:
        """The server's port."""
        return self._port

    async def start_server(self) -> None:
        """Start the server, the second time on the same port."""
        settings = RosbridgeSettings(host="127.0.0.1", port=self._port)
        graph = self.graph
        self.api = Rosapi(
            self._gateway, graph.store, style=graph.style, settings=settings, ask_type=graph.ask_type
        )
        self._server = RosbridgeServer(
            self._gateway,
            graph.store,
            settings,
            style=graph.style,
            ask_service_type=graph.ask_type,
            local_services=self.api,
        )
        await self._server.start()
        self._port = self._server.port

    async def stop_server(self) -> None:
        """Stop the server and close all connections."""
        if self._server is not None:
            await self._server.close()
            self._server = None

    async def is_served(self, service: str) -> bool:
        """Return whether the robot finds a service."""
        return service in (await self.talker.snapshot()).services

    def payload(self, type_name: str, value: dict[str, Any]) -> bytes:
        """Return the serialization of a JSON value."""
        codec = self.graph.store.codec(type_name)
        return JsonForm(self.graph.style).from_json(codec, value, Time())

    def collect(self, topic: str, type_name: str) -> None:
        """Store the messages of a topic in `received`."""
        messages = self.received.setdefault(topic, [])

        async def listen() -> None:
            async for message in self.talker.messages(topic, type_name):
                messages.append(message)

        self._tasks.append(asyncio.ensure_future(listen()))

    async def publish_regularly(
        self, topic: str, type_name: str, value: dict[str, Any], period_s: float
    ) -> None:
        """Publish a message repeatedly until the stage ends."""
        publisher = await self.talker.publisher(topic, type_name)
        payload = self.payload(type_name, value)

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
async def robot_stage(graph: WebGraph) -> AsyncIterator[RobotStage]:
    """Run the robot and the server until the block ends."""
    talker = TypedGraph(await graph.join("/talker"), graph.store)
    gateway = await graph.join("/gateway")
    stage = RobotStage(graph, talker, gateway)
    try:
        latched = await talker.publisher("/latched", "std_msgs/String", latch=True)
        latched.publish(data="kept")
        await stage.publish_regularly("/pose", "geometry_msgs/PoseStamped", POSE[graph.style], 0.02)
        await stage.publish_regularly("/scan", "sensor_msgs/LaserScan", SCAN, 0.2)
        content = (bytes(range(256)) * 1200)[:IMAGE_BYTES]
        image = {"header": {"frame_id": "camera"}, "data": b64encode(content).decode()}
        await stage.publish_regularly("/image", "sensor_msgs/Image", image, 0.2)
        await stage.publish_regularly("/fast", "std_msgs/UInt32", {"data": 7}, 0.005)
        await talker.service_server("/enable", "std_srvs/SetBool", _enable)
        await talker.service_server("/fail", "std_srvs/Trigger", _fail)
        await _serve_action(stage)
        await stage.start_server()
        assert stage.api is not None
        async with offering_rosapi(stage.api, graph.join, gateway):
            yield stage
    finally:
        await stage.close()
        await gateway.close()
        await talker.close()


def _enable(request: Message) -> dict[str, Any]:
    return {"success": request.data, "message": "enabled"}


def _fail(_: Message) -> dict[str, Any]:
    raise ServiceCallError("the motor is missing")


async def _serve_action(stage: RobotStage) -> None:
    """Answer every goal of the action /lookup, like an actionlib server."""
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
            # A real server is slower: the client's subscription may not exist yet.
            await results.wait_for_subscriber(30.0)
            text = f"{goal.goal.source_frame} to {goal.goal.target_frame}"
            results.publish(status=status, result={"error": {"error_string": text}})

    stage.collect("/lookup/cancel", "actionlib_msgs/GoalID")
    stage._tasks.append(asyncio.ensure_future(answer()))
