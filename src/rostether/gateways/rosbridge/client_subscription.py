"""One client's subscription to one topic, with rate, queue and form of its messages.

A client may subscribe to a topic several times with different ids. It gets each message once, according to
the most demanding subscription. `throttle_rate` without a queue drops messages that come too soon. With a
queue, messages are sent at that rate.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from enum import StrEnum

from msgspec import Struct

from rostether.errors import RemoteProtocolError, RostetherError
from rostether.gateways.client_json import show
from rostether.gateways.rosbridge.outbox import Outbox
from rostether.gateways.rosbridge.request import Request
from rostether.gateways.rosbridge.settings import MAX_QUEUED_MESSAGES
from rostether.gateways.shared_subscriptions import Batch, PublisherConnection, SharedSubscription
from rostether.gateways.type_names import short_type
from rostether.msgdef.interface import ANY_TYPE

# Smaller fragments would be mostly overhead, and a large message would need millions of them.
MIN_FRAGMENT_BYTES = 32

# The limit of subscriptions of one client to the same topic: a page has a few, and each change merges all.
MAX_REQUESTS = 100

_MS = 1e-3


class Compression(StrEnum):
    """The encodings of messages; if a client requests several for a topic, the last one here is used."""

    NONE = "none"
    PNG = "png"
    CBOR = "cbor"
    CBOR_RAW = "cbor-raw"


_STRENGTH = list(Compression)


class Delivery(Struct, frozen=True):
    """The rate, queue and form of the messages of one subscription, or the form of a response."""

    throttle_s: float = 0.0
    queue_length: int = 0
    fragment_bytes: int | None = None
    compression: Compression = Compression.NONE

    @classmethod
    def read(cls, request: Request) -> Delivery:
        """Return the delivery that a message requests. Raises RemoteProtocolError."""
        name = request.optional_word("compression") or Compression.NONE
        try:
            compression = Compression(name)
        except ValueError:
            known = ", ".join(Compression)
            raise RemoteProtocolError(f"compression must be one of {known}, got {show(name)}") from None
        fragment_bytes = request.count("fragment_size", 0)
        return cls(
            request.number("throttle_rate", 0) * _MS,
            request.count("queue_length", 0),
            max(fragment_bytes, MIN_FRAGMENT_BYTES) if fragment_bytes else None,
            compression,
        )


def merge(settings: list[Delivery]) -> Delivery:
    """Return the settings that satisfy all subscriptions of a client."""
    sizes = [each.fragment_bytes for each in settings if each.fragment_bytes is not None]
    return Delivery(
        min(each.throttle_s for each in settings),
        min(each.queue_length for each in settings),
        min(sizes, default=None),
        max((each.compression for each in settings), key=_STRENGTH.index),
    )


class ClientSubscription:
    """A topic that a client subscribes to; `topic` is the name that the client uses."""

    def __init__(
        self, topic: str, outbox: Outbox[ClientSubscription], report_error: Callable[[str], None]
    ) -> None:
        self.topic = topic
        self.delivery = Delivery()
        self.dropped_count = 0
        # How many dropped messages were reported to the client, and when it may receive the next report.
        self.reported_count = 0
        self.next_report_s = 0.0
        self.queue_length = MAX_QUEUED_MESSAGES
        self.share: SharedSubscription | None = None
        self._outbox = outbox
        self._report_error = report_error
        self._settings: dict[object, Delivery] = {}
        self._type = ""
        self._refused: set[str] = set()
        self._next_s = 0.0
        self._held: deque[tuple[Batch, int]] = deque()
        self._timer: asyncio.TimerHandle | None = None

    def add_request(self, request_id: object, delivery: Delivery, type_name: str) -> None:
        """Add the settings of a subscription, or replace those of the same id. Raises RemoteProtocolError."""
        if len(self._settings) >= MAX_REQUESTS and request_id not in self._settings:
            raise RemoteProtocolError(
                f"{self.topic} has {MAX_REQUESTS} subscriptions of this client; unsubscribe some ids"
            )
        if type_name:
            self._type = type_name
        self._settings[request_id] = delivery
        self._merge_settings()

    def remove_request(self, request_id: object) -> bool:
        """Remove the subscription of an id, or all of them for None; return whether any is left."""
        if request_id is None:
            self._settings.clear()
        else:
            self._settings.pop(request_id, None)
        if self._settings:
            self._merge_settings()
        return bool(self._settings)

    def enqueue(self, batch: Batch) -> None:
        """Queue the messages that the client wants."""
        if not self._fits(batch.connection):
            return
        for index in range(len(batch.payloads)):
            if self.delivery.throttle_s:
                self._throttle(batch, index)
            else:
                self._put(batch, index)

    def refuse(self, connection: PublisherConnection, reason: RostetherError | str) -> None:
        """Report once for each type why its messages are not sent."""
        if connection.type.name not in self._refused and len(self._refused) < MAX_REQUESTS:
            self._refused.add(connection.type.name)
            self._report_error(f"subscribe: {self.topic}: {reason}")

    async def close(self) -> None:
        """End the subscription, and discard waiting messages. Idempotent."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        self._held.clear()
        self._outbox.discard(self)
        if self.share is not None:
            await self.share.close()

    def _put(self, batch: Batch, index: int) -> None:
        self._outbox.put(self, batch, index, self.queue_length)

    def _merge_settings(self) -> None:
        self.delivery = merge(list(self._settings.values()))
        # In the protocol, zero means no queue: messages for a slow client wait within the server's limits.
        self.queue_length = min(self.delivery.queue_length or MAX_QUEUED_MESSAGES, MAX_QUEUED_MESSAGES)
        self._held = deque(self._held, maxlen=self.queue_length)

    def _fits(self, connection: PublisherConnection) -> bool:
        if not self._type or connection.type.name == ANY_TYPE:
            return True
        if short_type(self._type) == short_type(connection.type.name):
            return True
        self.refuse(connection, f"its type is {connection.type.name}, not {show(self._type)[1:-1]}")
        return False

    def _throttle(self, batch: Batch, index: int) -> None:
        now_s = asyncio.get_running_loop().time()
        if self.delivery.queue_length:
            # A full queue drops its oldest, as the client requested: this is not reported as a loss.
            self._held.append((batch, index))
            self._release()
        elif now_s >= self._next_s:
            self._advance(now_s)
            self._put(batch, index)

    def _release(self) -> None:
        """Queue the held messages that are due, and schedule the rest."""
        loop = asyncio.get_running_loop()
        if self._timer is not None and not self._timer.cancelled():
            if self._timer.when() > loop.time():
                return
            self._timer = None
        if not self._held:
            return
        if loop.time() >= self._next_s:
            self._advance(loop.time())
            self._put(*self._held.popleft())
        if self._held:
            self._timer = loop.call_at(self._next_s, self._timer_due)

    def _timer_due(self) -> None:
        self._timer = None
        self._release()

    def _advance(self, now_s: float) -> None:
        # A message that is a little late must not shift the schedule of the next one.
        throttle_s = self.delivery.throttle_s
        is_on_time = now_s - self._next_s < throttle_s / 2
        self._next_s = (self._next_s if is_on_time else now_s) + throttle_s
