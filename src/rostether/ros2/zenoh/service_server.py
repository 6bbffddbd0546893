"""One service that a node offers: a zenoh queryable and its token."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial

import zenoh

from rostether.errors import RostetherError
from rostether.graph.callbacks import report_error
from rostether.graph.ports import ServiceHandler
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.ros2.early_conversion import convert
from rostether.ros2.handover import Handover
from rostether.ros2.types.type_support import ServiceSupport
from rostether.ros2.zenoh.attachment import Attachment, parse_attachment
from rostether.ros2.zenoh.shared_session import NodeEntities
from rostether.ros2.zenoh.thread_state import keep_thread_state
from rostether.ros2.zenoh.tokens import TokenKind

# The limit of pending calls; a board answers one call at a time, so more calls would wait too long.
MAX_CALLS = 1000

# The limit of pending refusals: a peer may send any number of calls. Further calls get no answer and end at
# the caller's time limit.
MAX_REFUSALS = 100

# The time that a closing service waits until its callers have received an error, which takes milliseconds.
CLOSING_REPLY_S = 0.2

_log = logging.getLogger("rostether.ros2")


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
