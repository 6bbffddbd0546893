"""topic_tools' relay and throttle: publishes a topic under another name, at the full or a lower rate."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Sequence
from typing import TypeAlias

from rostether.errors import ConfigError
from rostether.graph.ports import Graph, Subscriber
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.nodes.output_topic import OutputTopic

# The polling interval for subscribers of a lazy node: the port does not report connections, and polling is
# cheap.
LAZY_POLL_S = 0.05

Select: TypeAlias = Callable[[Sequence[bytes]], Sequence[bytes]]

# Limits the memory for the sizes of messages, because empty messages do not count towards the byte limit.
MAX_SENT_MESSAGES = 100_000


def all_messages(payloads: Sequence[bytes]) -> Sequence[bytes]:
    """Select all messages, as a relay does."""
    return payloads


class MessageThrottle:
    """Selects messages that arrive at least 1 / `rate_hz` after the last selected one.

    `now_s` is the clock; when it jumps back, the interval restarts. Raises ConfigError unless the rate is
    above 0.
    """

    def __init__(self, rate_hz: float, now_s: Callable[[], float]) -> None:
        if not rate_hz > 0:
            raise ConfigError(f"{rate_hz:g} messages a second is not a valid rate; give more than 0")
        self._pause_s = 1 / rate_hz
        self._now_s = now_s
        self._last_s = 0.0

    def __call__(self, payloads: Sequence[bytes]) -> Sequence[bytes]:
        """Return the selected messages of a batch."""
        now_s = self._now_s()
        self._last_s = min(self._last_s, now_s)
        if not payloads or now_s - self._last_s <= self._pause_s:
            return ()
        self._last_s = now_s
        return payloads[:1]


class ByteThrottle:
    """Selects messages while the total of the last `window_s` seconds is below `limit_bytes`."""

    def __init__(self, limit_bytes: int, window_s: float, now_s: Callable[[], float]) -> None:
        self._limit_bytes = limit_bytes
        self._window_s = window_s
        self._now_s = now_s
        self._sent: deque[tuple[float, int]] = deque(maxlen=MAX_SENT_MESSAGES)

    def __call__(self, payloads: Sequence[bytes]) -> Sequence[bytes]:
        """Return the selected messages of a batch."""
        now_s = self._now_s()
        while self._sent and self._sent[0][0] < now_s - self._window_s:
            self._sent.popleft()
        passed = []
        spent_bytes = sum(size for _, size in self._sent)
        for payload in payloads:
            if spent_bytes >= self._limit_bytes:
                break
            self._sent.append((now_s, len(payload)))
            spent_bytes += len(payload)
            passed.append(payload)
        return passed


async def forward(
    graph: Graph, source: str, target: str, select: Select = all_messages, *, lazy: bool = False
) -> None:
    """Publish a topic's messages under another name until canceled.

    With `lazy`, it subscribes only while there is a subscriber, once the type is known. Raises ConfigError if
    input and output are the same topic, InvalidNameError, GraphError.
    """
    if graph.resolve(source) == graph.resolve(target):
        raise ConfigError(f"{graph.resolve(source)} would receive its own output; give the copy another name")
    output = OutputTopic(graph, target)
    subscriber: Subscriber | None = None

    def publish_selected(payloads: Sequence[bytes]) -> None:
        if passed := select(payloads):
            output.publish(passed)

    try:
        while True:
            is_wanted = not lazy or not output.is_advertised or output.subscriber_count > 0
            if is_wanted and subscriber is None:
                subscriber = await graph.subscribe(
                    source, ANY_MESSAGE, publish_selected, on_connection=output.advertise_as
                )
            elif not is_wanted and subscriber is not None:
                await subscriber.close()
                subscriber = None
            if not lazy:
                await asyncio.Event().wait()
            await asyncio.sleep(LAZY_POLL_S)
    finally:
        if subscriber is not None:
            await subscriber.close()
        await output.close()
