"""Waits for the subscribers of a topic that is new, so that its first messages reach them."""

from __future__ import annotations

import asyncio

from rostether.errors import RostetherError
from rostether.graph.ports import Graph, Publisher

# The time for subscribers to connect to a new topic; a few round trips on a network.
CONNECTING_S = 1.0

# How long a slow subscriber may delay the client, as with boards. Then that subscriber loses the oldest
# messages.
DRAIN_S = 0.1

# Shorter than a person notices; a subscriber on the same machine connects within milliseconds.
_POLL_S = 0.005


async def wait_for_subscribers(graph: Graph, publisher: Publisher) -> None:
    """Wait until the subscribers that the graph lists have connected, but at most `CONNECTING_S`."""
    try:
        async with asyncio.timeout(CONNECTING_S):
            topic = (await graph.snapshot()).topics.get(publisher.topic)
            expected = len(topic.subscribers) if topic is not None else 0
            # A graph does not report that a subscriber has connected; polling is cheap.
            while publisher.subscriber_count < expected:  # noqa: ASYNC110
                await asyncio.sleep(_POLL_S)
    except (RostetherError, TimeoutError):
        return
