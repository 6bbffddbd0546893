"""One client's subscription to one channel."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.errors import RostetherError
from rostether.gateways.foxglove.client_sender import ClientSender
from rostether.gateways.foxglove.foxglove_context import FoxgloveContext
from rostether.gateways.foxglove.server_messages import Channel
from rostether.gateways.shared_subscriptions import Batch, SharedSubscription
from rostether.msgdef.interface import ANY_MD5SUM


class Subscription:
    """Sends a topic's messages to a client unchanged; `report_error` gets an error of the graph."""

    def __init__(
        self,
        subscription_id: int,
        channel: Channel,
        context: FoxgloveContext,
        sender: ClientSender,
        report_error: Callable[[str], None],
    ) -> None:
        self.id = subscription_id
        self.channel = channel
        self._context = context
        self._sender = sender
        self._report_error = report_error
        self._md5sums = (channel.type.md5sum, ANY_MD5SUM)
        self._share: SharedSubscription | None = None
        self._is_closed = False
        self._opening = asyncio.ensure_future(self._open())

    async def close(self) -> None:
        """Unsubscribe; nothing is sent from now on."""
        self._is_closed = True
        self._sender.data.forget(self.id)
        await asyncio.wait([self._opening])
        if self._share is not None:
            await self._share.close()

    async def _open(self) -> None:
        try:
            self._share = await self._context.shared.subscribe(
                self.channel.topic,
                self._send_batch,
                lambda connection: self._context.channels.check_publisher(self.channel, connection),
            )
        except RostetherError as error:
            self._report_error(f"cannot subscribe to {self.channel.topic}: {error}")

    def _send_batch(self, batch: Batch) -> None:
        # Clients would decode messages of another type incorrectly.
        if not self._is_closed and batch.connection.type.md5sum in self._md5sums:
            self._sender.data.send(
                self.id,
                self._context.clock.now_ns(),
                batch.payloads,
                is_latched=batch.connection.is_latching,
            )
