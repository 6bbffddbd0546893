"""tf2_web_republisher: sends web pages the changed transforms that they request, at the requested rate.

A page calls the service `republish_tfs`, which returns a topic with the transforms of this page. Or it uses
the action `tf2_web_republisher`, like roslibjs' `TFClient`; then the feedback contains the transforms.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from typing import Any

from msgspec import Struct, field

from rostether.errors import ConfigError, GraphError, TransformError
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.tf_listener import tf_listener
from rostether.robot.tf_messages import to_message
from rostether.robot.transform import StampedTransform, Transform

NODE_NAME = "tf2_web_republisher"
SERVICE = "republish_tfs"
PACKAGE = "tf2_web_republisher"
ACTION = f"{PACKAGE}/TFSubscriptionAction"

# A page has one request or a few; each of them costs lookups at its rate.
MAX_REQUESTS = 256

# The limit in one request. Robots have a hundred frames; each is looked up at the request's rate.
MAX_FRAMES = 1_000

# Screens show 60 frames a second; the default of ten is enough to follow a robot.
MAX_RATE_HZ = 100.0
DEFAULT_RATE_HZ = 10.0

# The lifetime of a request after its last subscriber: closed pages do not cancel their requests.
IDLE_S = 15.0

# Clients of actions need the status only to see that the server runs.
STATUS_PERIOD_S = 1.0

# States of actionlib_msgs/GoalStatus.
_ACTIVE, _PREEMPTED, _REJECTED = 1, 2, 5


class _Request(Struct):
    """The request of a page, and the last transform sent for each frame."""

    target: str
    sources: tuple[str, ...]
    angle_rad: float
    distance_m: float
    period_s: float
    sent: dict[str, Transform] = field(default_factory=dict)

    @classmethod
    def read(cls, message: Any) -> _Request:
        """Read a goal or a service request. Raises ConfigError."""
        if len(message.source_frames) > MAX_FRAMES:
            raise ConfigError(
                f"{len(message.source_frames)} frames are too many; at most {MAX_FRAMES} are allowed"
            )
        rate_hz = message.rate if message.rate > 0 else DEFAULT_RATE_HZ
        return cls(
            message.target_frame.removeprefix("/"),
            tuple(dict.fromkeys(each.removeprefix("/") for each in message.source_frames)),
            message.angular_thres,
            message.trans_thres,
            1 / min(rate_hz, MAX_RATE_HZ),
        )

    def changed_transforms(self, buffer: TransformBuffer) -> list[StampedTransform]:
        """Return the transforms that are new, or have changed beyond the thresholds since they were sent."""
        found = []
        for source in self.sources:
            try:
                stamped = buffer.lookup(self.target, source)
            except TransformError:
                # The transform is not known yet, or no longer known.
                continue
            if self._has_moved(source, stamped.transform):
                self.sent[source] = stamped.transform
                found.append(stamped)
        return found

    def _has_moved(self, source: str, now: Transform) -> bool:
        before = self.sent.get(source)
        if before is None or self.angle_rad <= 0 or self.distance_m <= 0:
            return True
        cosine = abs(sum(a * b for a, b in zip(before.rotation, now.rotation, strict=True)))
        angle_rad = 2 * math.acos(min(1.0, cosine))
        return angle_rad > self.angle_rad or math.dist(before.translation, now.translation) > self.distance_m


async def republish_for_web(graph: TypedGraph, report: Callable[[str], None]) -> None:
    """Serve pages until canceled; `report` gets a line about each request that is refused."""
    async with (
        tf_listener(graph) as listener,
        closed_at_end(_Republisher(graph, listener.buffer, report)) as republisher,
    ):
        await republisher.run()


class _Republisher:
    def __init__(self, graph: TypedGraph, buffer: TransformBuffer, report: Callable[[str], None]) -> None:
        self._graph = graph
        self._buffer = buffer
        self._report = report
        self._count = 0
        self._tasks: set[asyncio.Task[None]] = set()
        # The tasks and GoalIDs of the goals by the text of the id, the oldest first.
        self._goals: dict[str, tuple[asyncio.Task[None], Any]] = {}

    async def run(self) -> None:
        graph = self._graph
        self._feedback = await graph.publisher(f"{NODE_NAME}/feedback", f"{ACTION}Feedback")
        self._result = await graph.publisher(f"{NODE_NAME}/result", f"{ACTION}Result")
        self._status = await graph.publisher(f"{NODE_NAME}/status", "actionlib_msgs/GoalStatusArray")
        await graph.service_server(SERVICE, f"{PACKAGE}/RepublishTFs", self._serve)
        await asyncio.gather(self._follow_goals(), self._follow_cancels(), self._publish_status())

    async def close(self) -> None:
        await cancel_all(*self._tasks)

    async def _serve(self, message: Any) -> dict[str, str]:
        request = _Request.read(message)
        if len(self._tasks) - len(self._goals) >= MAX_REQUESTS:
            raise GraphError(f"{MAX_REQUESTS} requests are already active; close some pages")
        self._count += 1
        publisher = await self._graph.publisher(f"tf_repub_{self._count}", f"{PACKAGE}/TFArray")
        timeout_s = message.timeout.to_ns() / 1e9
        start_task(self._tasks, self._serve_topic(publisher, request, timeout_s if timeout_s > 0 else IDLE_S))
        return {"topic_name": publisher.topic}

    async def _serve_topic(self, publisher: TypedPublisher[...], request: _Request, timeout_s: float) -> None:
        async with closed_at_end(publisher):
            await self._send(request, publisher, timeout_s, lambda fields: publisher.publish(fields))

    async def _follow_goals(self) -> None:
        async for goal in self._graph.messages(f"{NODE_NAME}/goal", f"{ACTION}Goal"):
            self._handle_goal(goal)

    def _handle_goal(self, message: Any) -> None:
        goal_id = message.goal_id
        try:
            request = _Request.read(message.goal)
        except ConfigError as error:
            self._report(str(error))
            self._end_goal(goal_id, _REJECTED, str(error))
            return
        self._cancel(goal_id.id)
        if len(self._goals) >= MAX_REQUESTS:
            self._cancel(next(iter(self._goals)))

        def send(fields: dict[str, Any]) -> None:
            self._feedback.publish(header=self._header(), status=_status(goal_id), feedback=fields)

        task = start_task(self._tasks, self._serve_goal(goal_id.id, request, send))
        self._goals[goal_id.id] = task, goal_id

    async def _serve_goal(
        self, name: str, request: _Request, send: Callable[[dict[str, Any]], object]
    ) -> None:
        await self._send(request, self._feedback, IDLE_S, send)
        self._cancel(name)

    async def _follow_cancels(self) -> None:
        async for goal_id in self._graph.messages(f"{NODE_NAME}/cancel", "actionlib_msgs/GoalID"):
            # In actionlib, an empty id with a time cancels the goals up to it; pages never send a time.
            for name in [goal_id.id] if goal_id.id else list(self._goals):
                self._cancel(name)

    def _cancel(self, name: str) -> None:
        if name in self._goals:
            task, goal_id = self._goals.pop(name)
            task.cancel()
            self._end_goal(goal_id, _PREEMPTED, "")

    def _end_goal(self, goal_id: Any, status: int, text: str) -> None:
        self._result.publish(header=self._header(), status=_status(goal_id, status, text), result={})

    async def _publish_status(self) -> None:
        while True:
            active = [_status(goal_id) for _, goal_id in self._goals.values()]
            self._status.publish(header=self._header(), status_list=active)
            await asyncio.sleep(STATUS_PERIOD_S)

    async def _send(
        self,
        request: _Request,
        publisher: TypedPublisher[...],
        timeout_s: float,
        send: Callable[[dict[str, Any]], object],
    ) -> None:
        """Send changed transforms until there has been no subscriber for `timeout_s`."""
        loop = asyncio.get_running_loop()
        last_subscriber_s = loop.time()
        while loop.time() - last_subscriber_s < timeout_s:
            if publisher.subscriber_count:
                last_subscriber_s = loop.time()
                # Transforms that are sent without a subscriber would not be sent again to later subscribers.
                changed = request.changed_transforms(self._buffer)
                if changed:
                    send(to_message(changed))
            await asyncio.sleep(request.period_s)

    def _header(self) -> dict[str, Any]:
        return {"stamp": self._graph.now()}


def _status(goal_id: Any, status: int = _ACTIVE, text: str = "") -> dict[str, Any]:
    return {"goal_id": goal_id, "status": status, "text": text}
