"""Calls one service with queries that have rmw_zenoh's attachment, and announces the client with a token."""

from __future__ import annotations

import asyncio
import time
from functools import partial
from typing import cast

import zenoh

from rostether.errors import ServiceCallError, ServiceUnavailableError
from rostether.graph.service_calls import answer_within
from rostether.mechanisms.text import fold_line
from rostether.ros2.early_conversion import convert
from rostether.ros2.types.type_support import ServiceSupport
from rostether.ros2.zenoh.attachment import Attachment, gid_of
from rostether.ros2.zenoh.shared_session import NodeEntities
from rostether.ros2.zenoh.tokens import TokenKind

# A query must have a time limit; a call without a limit ends when its server ends.
ENDLESS_S = 7 * 24 * 3600.0

# The maximum delay between a server's token and its queryable; it is about 1 ms on one machine.
REACH_S = 2.0
REACH_POLL_S = 0.001

# A server's error is one line of text.
MAX_ERROR_CHARACTERS = 2000


class ZenohServiceClient:
    """Calls one service; calls may run concurrently."""

    def __init__(self, service: str, support: ServiceSupport, *, node: NodeEntities) -> None:
        self.service = service
        self.support = support
        self._node = node
        self._token = node.declare(TokenKind.CLIENT, service, support)
        self._gid = gid_of(self._token.text)
        self._loop = asyncio.get_running_loop()
        self._querier = node.session.zenoh.declare_querier(
            node.key(service, support),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=ENDLESS_S,
        )
        self._sequence = 0

    async def call(self, request: bytes, timeout_s: float | None) -> bytes:
        """Call the service.

        Raises ServiceTimeoutError, ServiceUnavailableError, ServiceCallError, SerializationError.
        """
        cdr = self.support.request.to_cdr(request)
        await self._reach(timeout_s)
        loop = self._loop
        answer: asyncio.Future[zenoh.Reply | None] = loop.create_future()

        def settle(reply: zenoh.Reply | None) -> None:
            if not answer.done():
                answer.set_result(reply)

        def hand_over(reply: zenoh.Reply | None) -> None:
            # This runs in one of zenoh's threads; the event loop may have ended by then.
            if not loop.is_closed():
                loop.call_soon_threadsafe(settle, reply)

        def watch_server() -> None:
            if not self._node.session.graph.endpoints(TokenKind.SERVER, self.service):
                settle(None)

        self._sequence += 1
        cancellation = zenoh.CancellationToken()
        ask = partial(
            self._querier.get,
            zenoh.handlers.Callback(hand_over, lambda: hand_over(None), indirect=False),
            payload=cdr,
            attachment=Attachment(self._sequence, time.time_ns(), self._gid).encode(),
            cancellation_token=cancellation,
        )
        graph = self._node.session.graph
        graph.listen(TokenKind.SERVER, self.service, watch_server)
        try:
            async with answer_within(self.service, timeout_s):
                # In a thread, because zenoh blocks until the link has room, for 5 s if the server hangs.
                await loop.run_in_executor(self._node.session.call_threads, ask)
                reply = await answer
        finally:
            graph.unlisten(TokenKind.SERVER, self.service, watch_server)
            cancellation.cancel()
        if reply is None:
            raise ServiceUnavailableError(f"service {self.service} was shut down during the call")
        if reply.ok is None:
            data = b"" if reply.err is None else reply.err.payload.to_bytes()
            reason = fold_line(data[: 4 * MAX_ERROR_CHARACTERS].decode("utf-8", "replace"))
            raise ServiceCallError(
                reason[:MAX_ERROR_CHARACTERS] or f"service {self.service} failed without a reason"
            )
        return await convert(self.support.response.from_cdr, reply.ok.payload.to_bytes())

    def close(self) -> None:
        """Withdraw the client's token, and end its querier. Call it once."""
        self._token.withdraw()
        self._querier.undeclare()

    async def _reach(self, timeout_s: float | None) -> None:
        """Wait until zenoh has a route to the server: its token may arrive earlier.

        Raises ServiceUnavailableError.
        """
        deadline_s = time.monotonic() + (REACH_S if timeout_s is None else min(timeout_s, REACH_S))
        # The type stubs declare the status as bool.
        while not cast(zenoh.MatchingStatus, self._querier.matching_status).matching:
            if time.monotonic() > deadline_s:
                raise ServiceUnavailableError(
                    f"service {self.service} is listed, but zenoh cannot reach it; check that its node is "
                    "still running"
                )
            await asyncio.sleep(REACH_POLL_S)
