from __future__ import annotations

import asyncio

import pytest

from rostether.cli.topic.misfit_notice import shown_messages
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms import rate_limits
from unit.cli.command_shell import STORE

WRONG = b"\xff\xff\xff\xff"
RIGHT = b"\x02\x00\x00\x00ok"


@pytest.mark.parametrize(
    ("period_s", "reported"),
    [(1000.0, ["1 message does not", "8 messages do not"]), (0.0, ["1 message does not"])],
)
async def test_messages_that_cannot_be_decoded_are_counted_on_stderr(
    period_s: float,
    reported: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(rate_limits, "PERIOD_S", period_s)
    network = MemoryNetwork()
    talker, listener = [TypedGraph(await network.join(name), STORE) for name in ("/talker", "/listener")]
    publisher = await talker.publisher("/chatter", "std_msgs/String")
    async with shown_messages(listener.messages("/chatter")) as messages:
        first = asyncio.ensure_future(anext(messages))
        assert await publisher.wait_for_subscriber(60.0)
        publisher.raw.publish_raw([WRONG] * 8 + [RIGHT])
        assert (await first).data == "ok"
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == (2 if period_s else 8)
    for line, words in zip(lines, reported, strict=False):
        assert line.startswith(f"WARNING: /chatter: {words} fit")


async def test_nothing_is_reported_where_all_fit(capsys: pytest.CaptureFixture[str]) -> None:
    network = MemoryNetwork()
    talker, listener = [TypedGraph(await network.join(name), STORE) for name in ("/talker", "/listener")]
    publisher = await talker.publisher("/chatter", "std_msgs/String")
    async with shown_messages(listener.messages("/chatter")) as messages:
        first = asyncio.ensure_future(anext(messages))
        assert await publisher.wait_for_subscriber(60.0)
        publisher.raw.publish_raw([RIGHT])
        assert (await first).data == "ok"
    assert capsys.readouterr().err == ""
