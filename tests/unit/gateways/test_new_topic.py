from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from rostether.errors import GraphError
from rostether.gateways import new_topic
from rostether.gateways.new_topic import wait_for_subscribers
from rostether.graph.ports import Snapshot, TopicEntry


def graph(*subscribers: str) -> Any:
    async def snapshot() -> Snapshot:
        return Snapshot(topics={"/a": TopicEntry("/a", "std_msgs/String", ("/us",), subscribers)})

    return SimpleNamespace(snapshot=snapshot)


def publisher(count: int) -> Any:
    return SimpleNamespace(topic="/a", subscriber_count=count)


async def test_it_waits_for_all_that_are_listed() -> None:
    ours = publisher(1)
    waiting = asyncio.ensure_future(wait_for_subscribers(graph("/b", "/c"), ours))
    await asyncio.sleep(0.02)
    assert not waiting.done()
    ours.subscriber_count = 2
    await waiting


async def test_a_topic_without_subscribers_waits_for_none() -> None:
    await wait_for_subscribers(graph(), publisher(0))


async def test_one_that_never_connects_is_not_waited_for_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(new_topic, "CONNECTING_S", 0.02)
    await wait_for_subscribers(graph("/dead"), publisher(0))


async def test_a_graph_that_cannot_be_read_does_not_hold_it_up() -> None:
    async def snapshot() -> Snapshot:
        raise GraphError("away")

    await wait_for_subscribers(SimpleNamespace(snapshot=snapshot), publisher(0))
