"""One client's subscription to one channel, and the report of dropped messages."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.errors import RostetherError
from rostether.gateways.foxglove import server_messages as replies
from rostether.gateways.foxglove.channels import Channels
from rostether.gateways.foxglove.client_sender import ClientSender
from rostether.gateways.foxglove.server_messages import Channel, StatusLevel
from rostether.gateways.shared_subscriptions import (
    Batch,
    PublisherConnection,
    SharedSubscription,
    SharedSubscriptions,
)
from rostether.mechanisms.text import counted
from rostether.msgdef.interface import ANY_MD5SUM

_STATUS_ID = "slow-client"

# How often a client gets the number of lost messages.
_PERIOD_S = 5.0


class Subscription:
    """Sends a topic's messages to a client unchanged."""

    def __init__(
        self,
        subscription_id: int,
        channel: Channel,
        sender: ClientSender,
        channels: Channels,
        now_ns: Callable[[], int],
    ) -> None:
        self.id = subscription_id
        self.channel = channel
        self._sender = sender
        self._channels = channels
        self._now_ns = now_ns
        self._md5sums = (channel.type.md5sum, ANY_MD5SUM)
        self._share: SharedSubscription | None = None
        self._opening: asyncio.Task[None] | None = None
        self._is_closed = False

    def open(self, shared: SharedSubscriptions, report: Callable[[str], None]) -> None:
        """Subscribe on the graph, unless another client has; `report` gets an error of the graph."""
        self._opening = asyncio.ensure_future(self._open(shared, report))

    async def close(self) -> None:
        """Unsubscribe; nothing is sent from now on."""
        self._is_closed = True
        self._sender.data.forget(self.id)
        if self._opening is not None:
            await asyncio.wait([self._opening])
        if self._share is not None:
            await self._share.close()

    async def _open(self, shared: SharedSubscriptions, report: Callable[[str], None]) -> None:
        try:
            self._share = await shared.subscribe(self.channel.topic, self._send_batch, self._report_publisher)
        except RostetherError as error:
            report(f"cannot subscribe to {self.channel.topic}: {error}")

    def _report_publisher(self, connection: PublisherConnection) -> None:
        self._channels.check_publisher(self.channel, connection)

    def _send_batch(self, batch: Batch) -> None:
        # Clients would decode messages of another type incorrectly.
        if not self._is_closed and batch.connection.type.md5sum in self._md5sums:
            self._sender.data.send(self.id, self._now_ns(), batch.payloads)


class DroppedReport:
    """Counts lost messages; the status is removed after some time without losses."""

    def __init__(self, send: Callable[[str], None]) -> None:
        self._send = send
        self.count = 0
        self._reported = 0
        self._timer: asyncio.TimerHandle | None = None

    def add(self, count: int) -> None:
        """Count lost messages; they are reported now, or with the next report."""
        self.count += count
        if self._timer is None:
            self._report()

    def close(self) -> None:
        """Stop reporting."""
        if self._timer is not None:
            self._timer.cancel()

    def _report(self) -> None:
        self._timer = None
        if self.count == self._reported:
            self._send(replies.remove_status([_STATUS_ID]))
            return
        self._reported = self.count
        text = f"this client reads too slowly: {counted(self.count, 'message')} dropped so far"
        self._send(replies.status(StatusLevel.WARNING, text, _STATUS_ID))
        self._timer = asyncio.get_running_loop().call_later(_PERIOD_S, self._report)
