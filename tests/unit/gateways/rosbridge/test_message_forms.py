from __future__ import annotations

import asyncio
import json

import pytest

from loop_watch import CallbackWatch
from rostether.errors import SerializationError
from rostether.gateways.rosbridge.client_subscription import Compression
from rostether.gateways.rosbridge.form_source import Style
from rostether.gateways.rosbridge.message_forms import MessageForms
from rostether.gateways.rosbridge.values import JsonText
from rostether.gateways.shared_subscriptions import Batch, PublisherConnection
from rostether.graph.message_stream import LearnedTypes
from rostether.msgdef.registry import Registry
from rostether.rostime import Time
from rostether.serde.store import TypeStore

STORE = TypeStore(Registry())
MAP = STORE.codec("nav_msgs/OccupancyGrid")
CELLS = [0, -1, 100, 50] * 125_000


def forms() -> MessageForms:
    return MessageForms(STORE, Style.ROS1, lambda: Time(1, 2))


def batch(payload: bytes) -> Batch:
    known = STORE.registry.message_type("nav_msgs/OccupancyGrid")
    fields = {"type": known.name, "md5sum": known.md5sum, "message_definition": known.definition}
    return Batch(PublisherConnection("/map", fields, LearnedTypes(STORE)), [payload])


async def test_a_large_message_is_converted_once_and_does_not_hold_the_loop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    there, sent = forms(), batch(MAP.encode({"data": CELLS}))
    watch = CallbackWatch(monkeypatch)
    first, second = await asyncio.gather(
        *(there.published("/map", sent, 0, Compression.NONE) for _ in range(2))
    )
    watch.check("a map")
    assert first is second
    assert json.loads(first)["msg"]["data"] == CELLS
    assert await there.published("/map", sent, 0, Compression.NONE) is first


async def test_a_large_message_that_does_not_fit_its_type_is_refused_for_every_client() -> None:
    there, sent = forms(), batch(MAP.encode({"data": CELLS})[:-1])
    for _ in range(2):
        with pytest.raises(SerializationError):
            await there.published("/map", sent, 0, Compression.NONE)


async def test_a_large_response_does_not_hold_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    payload = MAP.encode({"data": CELLS})
    watch = CallbackWatch(monkeypatch)
    response = await forms().response("nav_msgs/OccupancyGrid", payload)
    watch.check("a map")
    assert isinstance(response, JsonText)
    assert json.loads(response)["data"] == CELLS
