"""Services over zenoh: queries and queryables with rmw_zenoh's attachment, announced with tokens."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import cast

import zenoh

from rostether.errors import RostetherError, ServiceCallError, ServiceUnavailableError
from rostether.graph.callbacks import report_error
from rostether.graph.ports import ServiceHandler
from rostether.graph.service_calls import answer_within
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.mechanisms.text import fold_line
from rostether.ros2.early_conversion import convert
from rostether.ros2.handover import Handover
from rostether.ros2.types.type_support import ServiceSupport
from rostether.ros2.zenoh.attachment import Attachment, gid_of, parse_attachment
from rostether.ros2.zenoh.shared_session import NodeEntities
from rostether.ros2.zenoh.thread_state import keep_thread_state
from rostether.ros2.zenoh.tokens import TokenKind

# A query must have a time limit; a call without a limit ends when its server ends.
ENDLESS_S = 7 * 24 * 3600.0

# The maximum delay between a server's token and its queryable; it is about 1 ms on one machine.
REACH_S = 2.0
REACH_POLL_S = 0.001

# A server's error is one line of text.
MAX_ERROR_CHARACTERS = 2000

# The limit of pending calls; a board answers one call at a time, so more calls would wait too long.
MAX_CALLS = 1000

# The limit of pending refusals: a peer may send any number of calls. Further calls get no answer and end at
# the caller's time limit.
MAX_REFUSALS = 100

# The time that a closing service waits until its callers have received an error, which takes milliseconds.
CLOSING_REPLY_S = 0.2

_log = logging.getLogger("rostether.ros2")


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


class ZenohServiceServer:
    """Implements `graph.ports.ServiceServer`; calls run concurrently."""

    def __init__(
        self,
        service: str,
        support: ServiceSupport,
        handler: ServiceHandler,
        *,
        node: NodeEntities,
        on_close: Callable[[ZenohServiceServer], None],
    ) -> None:
        self.service = service
        self._support = support
        self._handler = handler
        self._on_close = on_close
        self._is_closed = False
        self._threads = node.session.call_threads
        self._calls: set[asyncio.Task[None]] = set()
        self._closing_replies: list[Future[None]] = []
        self._key = node.key(service, support)
        self._queue: Handover[zenoh.Query] = Handover(self._handle_queries, limit=MAX_CALLS)
        self._queryable = node.session.zenoh.declare_queryable(
            self._key, zenoh.handlers.Callback(self._put, indirect=False), complete=True
        )
        self._token = node.declare(TokenKind.SERVER, service, support)

    async def close(self) -> None:
        """Unadvertise; pending calls fail. Idempotent."""
        if self._is_closed:
            return
        self._is_closed = True
        self._token.withdraw()
        self._queryable.undeclare()
        self._queue.close()
        await cancel_all(*self._calls)
        if self._closing_replies:
            await asyncio.wait(map(asyncio.wrap_future, self._closing_replies), timeout=CLOSING_REPLY_S)
        self._on_close(self)

    def _put(self, query: zenoh.Query) -> None:
        keep_thread_state()
        self._queue.put(query)

    def _handle_queries(self, queries: list[zenoh.Query]) -> None:
        for query in queries:
            if len(self._calls) >= MAX_CALLS + MAX_REFUSALS:
                query.drop()
                continue
            start_task(self._calls, self._answer(query, is_refused=len(self._calls) >= MAX_CALLS))

    async def _answer(self, query: zenoh.Query, *, is_refused: bool) -> None:
        busy = f"service {self.service} is busy with {MAX_CALLS} calls; try again later"
        try:
            reply = _refusal(query, busy) if is_refused else await self._work(query)
        except asyncio.CancelledError:
            last = _refusal(query, f"service {self.service} was shut down during the call")
            self._closing_replies.append(self._threads.submit(_finish, query, last))
            raise
        # Blocks until the caller's link has room: up to 5 s when the caller hangs.
        await asyncio.get_running_loop().run_in_executor(self._threads, _finish, query, reply)

    async def _work(self, query: zenoh.Query) -> Callable[[], object]:
        """Handle a call; return the function that sends the response."""
        attachment = None if query.attachment is None else parse_attachment(query.attachment.to_bytes())
        if attachment is None or query.payload is None:
            return _refusal(query, f"a call of {self.service} without rmw_zenoh's attachment or a request")
        try:
            request = await convert(self._support.request.from_cdr, query.payload.to_bytes())
            response = self._support.response.to_cdr(await self._handler(request))
        except RostetherError as error:
            return _refusal(query, str(error))
        except Exception as error:  # noqa: BLE001 - an error in a handler must not end the service
            report_error(f"handler of service {self.service}", error)
            return _refusal(query, f"error processing request: {error}")
        echo = Attachment(attachment.sequence, time.time_ns(), attachment.gid)
        return partial(query.reply, self._key, response, attachment=echo.encode())


def _refusal(query: zenoh.Query, text: str) -> Callable[[], object]:
    return partial(query.reply_err, text.encode("utf-8", "replace"))


def _finish(query: zenoh.Query, reply: Callable[[], object]) -> None:
    """Send the response, in a thread."""
    with query:
        try:
            reply()
        except zenoh.ZError as error:
            _log.debug("an answer did not reach its caller: %s", error)
