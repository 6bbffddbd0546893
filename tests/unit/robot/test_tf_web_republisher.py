"""tf2_web_republisher: the service and the action by which web pages request transforms."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, aclosing
from typing import Any

import pytest
import pytest_asyncio

from rostether.errors import ServiceCallError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.mechanisms.block_end import task_beside
from rostether.robot import tf_web_republisher
from rostether.robot.tf_messages import tf_publisher, to_message
from rostether.robot.tf_web_republisher import MAX_FRAMES, republish_for_web
from rostether.robot.transform import StampedTransform, Transform, quaternion_from_rpy
from unit.robot.graphs import entered
from waiting import until

ASK = {"source_frames": ["/arm", "nowhere"], "target_frame": "world", "rate": 100.0}
ACTION = "tf2_web_republisher/TFSubscriptionAction"


class World:
    def __init__(self, page: TypedGraph, tf: TypedPublisher[...], problems: list[str]) -> None:
        self.page = page
        self.problems = problems
        self._tf = tf
        self._stamp_ns = 10**9

    def move(self, x: float, yaw: float = 0.0) -> None:
        self._stamp_ns += 10**7
        turned = Transform((x, 0.0, 0.0), quaternion_from_rpy(0.0, 0.0, yaw))
        self._tf.publish(to_message([StampedTransform("world", "arm", self._stamp_ns, turned)]))

    async def collect(self, topic: str, type_name: str, into: list[Any]) -> None:
        async with aclosing(aiter(self.page.messages(topic, type_name))) as messages:
            async for message in messages:
                into.append(message)


@pytest_asyncio.fixture
async def world() -> AsyncIterator[World]:
    network = MemoryNetwork()
    problems: list[str] = []
    async with AsyncExitStack() as stack:
        graphs = [await stack.enter_async_context(entered(network, name)) for name in ("/repub", "/page")]
        tf = await tf_publisher(graphs[1])
        await stack.enter_async_context(task_beside(republish_for_web(graphs[0], problems.append)))
        await until(lambda: "/republish_tfs" in network.snapshot().services and tf.subscriber_count > 0)
        await until(lambda: "/tf2_web_republisher/cancel" in network.snapshot().topics)
        yield World(graphs[1], tf, problems)


async def test_a_page_requests_transforms_by_the_service(world: World) -> None:
    ask = {**ASK, "trans_thres": 0.1, "angular_thres": 0.1}
    answer = await world.page.call("/republish_tfs", "tf2_web_republisher/RepublishTFs", ask)
    assert answer.topic_name == "/tf_repub_1"
    again = await world.page.call("/republish_tfs", "tf2_web_republisher/RepublishTFs", ask)
    assert again.topic_name == "/tf_repub_2"
    got: list[Any] = []
    async with task_beside(world.collect("/tf_repub_1", "tf2_web_republisher/TFArray", got)):
        world.move(1.0)
        await until(lambda: len(got) == 1)
        (sent,) = got[0].transforms
        assert (sent.header.frame_id, sent.child_frame_id) == ("world", "arm")
        assert sent.transform.translation.x == 1.0
        # A move below the thresholds, then one beyond the distance, then one beyond the angle.
        world.move(1.05)
        await asyncio.sleep(0.05)
        assert len(got) == 1
        world.move(1.2)
        await until(lambda: len(got) == 2)
        world.move(1.2, math.pi / 2)
        await until(lambda: len(got) == 3)


async def test_a_topic_ends_with_its_page(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tf_web_republisher, "IDLE_S", 0.05)
    await world.page.call("/republish_tfs", "tf2_web_republisher/RepublishTFs", ASK)

    async def topics() -> set[str]:
        return set((await world.page.raw.snapshot()).topics)

    while "/tf_repub_1" in await topics():
        await asyncio.sleep(0.01)


async def test_a_page_requests_transforms_by_the_action_like_roslibjs(world: World) -> None:
    feedback: list[Any] = []
    results: list[Any] = []
    goals = await world.page.publisher("/tf2_web_republisher/goal", f"{ACTION}Goal")
    cancels = await world.page.publisher("/tf2_web_republisher/cancel", "actionlib_msgs/GoalID")
    async with (
        task_beside(world.collect("/tf2_web_republisher/feedback", f"{ACTION}Feedback", feedback)),
        task_beside(world.collect("/tf2_web_republisher/result", f"{ACTION}Result", results)),
    ):
        await until(lambda: goals.subscriber_count > 0 and cancels.subscriber_count > 0)
        world.move(1.0)
        goals.publish(goal_id={"id": "goal_1"}, goal=ASK)
        await until(lambda: len(feedback) > 2)
        assert feedback[0].status.goal_id.id == "goal_1"
        assert feedback[0].feedback.transforms[0].child_frame_id == "arm"
        cancels.publish(id="goal_1")
        await until(lambda: [each.status.status for each in results] == [2])
        count = len(feedback)
        await asyncio.sleep(0.05)
        assert len(feedback) <= count + 1
        goals.publish(goal_id={"id": "goal_2"}, goal={"source_frames": ["a"] * (MAX_FRAMES + 1)})
        await until(lambda: [each.status.status for each in results] == [2, 5])
    assert world.problems == [f"{MAX_FRAMES + 1} frames are too many; at most {MAX_FRAMES} are allowed"]


async def test_requests_are_bounded(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tf_web_republisher, "MAX_REQUESTS", 1)
    await world.page.call("/republish_tfs", "tf2_web_republisher/RepublishTFs", ASK)
    with pytest.raises(ServiceCallError, match="1 requests are already active"):
        await world.page.call("/republish_tfs", "tf2_web_republisher/RepublishTFs", ASK)
