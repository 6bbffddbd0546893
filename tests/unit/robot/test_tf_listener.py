from __future__ import annotations

import pytest

from rostether.graph.memory_network import MemoryNetwork
from rostether.mechanisms.block_end import task_beside
from rostether.robot.static_transforms import StaticTransform, publish_static_transform
from rostether.robot.tf_listener import TfListener, tf_listener
from rostether.robot.tf_messages import TF_TYPE, from_message, tf_publisher, to_message
from rostether.robot.tf_statistics import TfStatistics
from rostether.robot.transform import StampedTransform, Transform
from rostether.rostime import Time
from unit.robot.graphs import entered
from waiting import until

SECOND = 10**9
STEP = StampedTransform("world", "base", 100 * SECOND, Transform((1.0, 2.0, 3.0)))


async def test_static_and_moving_transforms_arrive() -> None:
    network = MemoryNetwork()
    refusals: list[str] = []
    async with (
        entered(network, "/robot") as robot,
        entered(network, "/late") as late,
        task_beside(
            publish_static_transform(robot, StaticTransform("base", "laser", Transform((0.5, 0.0, 0.0))))
        ),
    ):
        publisher = await tf_publisher(robot)
        async with tf_listener(late, on_refusal=refusals.append) as listener:
            assert await publisher.wait_for_subscriber(5)
            wrong = StampedTransform("base", "base", 1, Transform())
            publisher.publish(to_message([STEP, wrong]))
            await until(lambda: not listener.buffer.lookup_error("world", "laser"))
            found = listener.buffer.lookup("world", "laser")
    assert found.transform.translation == (1.5, 2.0, 3.0)
    assert len(refusals) == 1
    assert refusals[0].startswith("TF_SELF_TRANSFORM")


async def test_a_static_transform_with_a_period_is_published_repeatedly() -> None:
    network = MemoryNetwork()
    static = StaticTransform("a", "b", Transform(), period_s=0.02)
    async with (
        entered(network, "/robot") as robot,
        entered(network, "/eye") as eye,
        tf_listener(eye) as listener,
        task_beside(publish_static_transform(robot, static)),
    ):

        def has_several() -> bool:
            cache = listener.buffer.cache_of("b")
            return cache is not None and cache.latest_ns > cache.oldest_ns

        await until(has_several)
        cache = listener.buffer.cache_of("b")
        assert cache is not None
        assert not cache.is_static
        # The publisher ends with its node.
        await robot.close()


async def test_a_jump_back_in_time_clears_the_buffer(monkeypatch: pytest.MonkeyPatch) -> None:
    refusals: list[str] = []
    now_ns = 200 * SECOND
    async with entered(MemoryNetwork(), "/n") as node:
        monkeypatch.setattr(node, "now", lambda: Time.from_ns(now_ns))
        codec = node.store.codec(TF_TYPE)
        listener = TfListener(node, refusals.append)
        handle = listener.handler(False, {"callerid": "/robot"})
        handle([codec.encode(to_message([STEP])), b"noise"])
        assert listener.buffer.children == ["base"]
        assert len(refusals) == 1
        now_ns = 5 * SECOND
        handle([codec.encode(to_message([]))])
    assert listener.buffer.children == []
    assert "jump back in time" in refusals[1]


async def test_messages_contain_the_whole_transform() -> None:
    async with entered(MemoryNetwork(), "/n") as node:
        codec = node.store.codec(TF_TYPE)
        stamped = StampedTransform("a", "b", 1_234_567_890, Transform((1.0, 2.0, 3.0), (0.5, -0.5, 0.5, 0.5)))
        assert list(from_message(codec.decode(codec.encode(to_message([stamped]))))) == [stamped]


def test_statistics_count_messages_of_nodes_and_delays_of_frames() -> None:
    statistics = TfStatistics()
    for second in (0, 1, 2):
        both = [
            StampedTransform("world", "/a", second * SECOND, Transform()),
            StampedTransform("world", "b", (second - 1) * SECOND, Transform()),
        ]
        statistics.add(both, "/robot", False, (second + 1) * SECOND)
    statistics.add([StampedTransform("b", "c", 1, Transform())], "/still", True, 5 * SECOND)
    assert statistics.nodes["/robot"].rate_hz == 1.0
    assert statistics.nodes["/robot"].average_s == 1.5
    assert (statistics.frames["a"].average_s, statistics.frames["b"].max_s) == (1.0, 2.0)
    assert statistics.frames["c"].average_s == 0.0
    assert statistics.nodes["/still"].rate_hz == 0.0
