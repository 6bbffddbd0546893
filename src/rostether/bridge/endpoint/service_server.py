"""A service that the board serves: one call at a time, the others wait.

The wire has no correlation id, so a response belongs to the one call in flight. After a call that timed out
the board may still answer, and that answer must not become the next call's. So no other call is sent until
the late answer was dropped, or the board shows that it has finished the call. The established device library
serves a call in its loop, and requests the time again only when it is done. If a board requests
the time during calls too, its requests show nothing.
"""

from __future__ import annotations

import asyncio

from rostether.bridge.endpoint.board_line import BoardLine, stop_receiving
from rostether.bridge.reporter import Notices
from rostether.bridge.settings import BridgeSettings
from rostether.errors import LocalProtocolError, ServiceCallError, ServiceTimeoutError
from rostether.graph.ports import Graph, Level, ServiceServer
from rostether.mechanisms.tasks import occurs_within
from rostether.mechanisms.text import counted
from rostether.rosserial.events import ServiceAnnounced
from rostether.rosserial.frame import MAX_PAYLOAD_BYTES
from rostether.serde.store import TypeStore

# A board requests the time every 2.5 s, and unconfigures itself after 11 s without an answer. If it has not
# shown in this time that it finished the call that timed out, it has lost the request.
QUARANTINE_S = 15.0
# A board that was busy with a call has skipped more than two time requests; the line may lose two.
BUSY_S = 6.0


class ServiceServerEndpoint:
    """One service of the board; `dropped_count` counts responses that came too late."""

    def __init__(
        self,
        info: ServiceAnnounced,
        store: TypeStore,
        graph: Graph,
        notices: Notices,
        settings: BridgeSettings,
    ) -> None:
        self.info = info
        self.message_count = 0
        self.misfit_count = 0
        self.dropped_count = 0
        self._type = store.registry.service_type(info.type)
        self._request_layout = store.layout(self._type.request.name)
        self._response_layout = store.layout(self._type.response.name)
        self._graph = graph
        self._notices = notices
        self._settings = settings
        self._line: BoardLine | None = None
        self._server: ServiceServer | None = None
        self._lock = asyncio.Lock()
        self._waiting = 0
        self._response: asyncio.Future[bytes] | None = None
        self._sent_s = 0.0
        self._asked_s = 0.0
        self._earlier_call_ended = asyncio.Event()
        self._earlier_call_ended.set()
        self._quarantine: asyncio.TimerHandle | None = None

    def attach(self, line: BoardLine, info: ServiceAnnounced) -> None:
        """Serve calls through a connection from now on."""
        self.detach()
        self.info = info
        self._line = line
        line.receivers[info.response.topic_id] = self.receive

    def detach(self) -> None:
        """Release the connection; a call in flight fails."""
        self.fail_call("lost")
        if self._line is not None:
            stop_receiving(self._line, self.info.response.topic_id, self.receive)
            self._line = None

    def fail_call(self, reason: str) -> None:
        """Fail the call in flight: the board was `reason` (lost, reset), and will not answer it."""
        if self._response is not None and not self._response.done():
            self._response.set_exception(
                ServiceCallError(f"the board was {reason} during the call of {self.info.name}; call it again")
            )
        self._end_quarantine()

    def time_requested(self, now_s: float) -> None:
        """Record a time request: after a silence as long as a call, the board has finished that call."""
        silence_s = now_s - max(self._asked_s, self._sent_s)
        self._asked_s = now_s
        if silence_s >= BUSY_S:
            self._end_quarantine()

    def __repr__(self) -> str:
        return f"<service server {self.info.name} [{self.info.type}]>"

    async def open(self) -> None:
        """Advertise. Raises GraphError, InvalidNameError."""
        self._server = await self._graph.advertise_service(self.info.name, self._type, self.call)

    async def close(self) -> None:
        """Unadvertise."""
        if self._server is not None:
            await self._server.close()

    def _end_quarantine(self) -> None:
        if self._quarantine is not None:
            self._quarantine.cancel()
            self._quarantine = None
        self._earlier_call_ended.set()

    def receive(self, payloads: list[bytes]) -> None:
        """Handle responses from the board."""
        for payload in payloads:
            response = self._response
            if response is None or response.done():
                self.dropped_count += 1
                self._end_quarantine()
            elif self._response_layout.accepts(payload):
                self.message_count += 1
                response.set_result(payload)
            else:
                self.misfit_count += 1
                explanation = self._response_layout.explain(payload)
                response.set_exception(
                    ServiceCallError(
                        f"the board answered {self.info.name} with a bad response: {explanation}; generate "
                        "the message headers of its sketch again"
                    )
                )

    async def call(self, request: bytes) -> bytes:
        """Pass a call on to the board; return the response. Raises ServiceCallError, ServiceTimeoutError."""
        name = self.info.name
        # A longer one is refused later: checking a request of many MB would block all boards.
        if len(request) <= MAX_PAYLOAD_BYTES and not self._request_layout.accepts(request):
            raise ServiceCallError(
                f"{name}: bad request: {self._request_layout.explain(request)}; "
                "give both ends the same definition"
            )
        if self._waiting >= self._settings.queued_calls:
            raise ServiceCallError(
                f"{name}: the limit of calls that wait for the board ({self._waiting}) is reached; "
                "try again later"
            )
        limit_s = self._settings.service_timeout_s
        self._waiting += 1
        try:
            async with asyncio.timeout(limit_s):
                await self._lock.acquire()
        except TimeoutError:
            raise ServiceTimeoutError(
                f"{name}: waited {limit_s:g} s for earlier calls that the board has not answered; call "
                "again later"
            ) from None
        finally:
            self._waiting -= 1
        try:
            await self._wait_for_earlier_call(limit_s)
            return await self._call_board(request, limit_s)
        finally:
            self._lock.release()

    async def _wait_for_earlier_call(self, limit_s: float) -> None:
        if not await occurs_within(self._earlier_call_ended, limit_s):
            raise ServiceTimeoutError(
                f"{self.info.name}: the board is still busy with an earlier call after {limit_s:g} s; "
                "call again later"
            )

    async def _call_board(self, request: bytes, limit_s: float) -> bytes:
        line, name = self._line, self.info.name
        if line is None:
            raise ServiceCallError(f"{name}: the board is not connected; call again when it is back")
        limit_bytes = self.info.request.buffer_size
        if len(request) > limit_bytes:
            reason = (
                f"the request has {counted(len(request), 'byte')}, but the board's buffer has only "
                f"{limit_bytes}; enlarge it in the sketch, or send a smaller request"
            )
            self._notices.report_episode(f"request {name}", Level.ERROR, f"a call of {name} failed: {reason}")
            raise ServiceCallError(f"{name}: {reason}")
        try:
            line.outbox.answer(self.info.request.topic_id, request)
        except LocalProtocolError as error:
            raise ServiceCallError(
                f"{name}: the board was reset and has not announced it again yet; call again in a moment"
            ) from error
        loop = asyncio.get_running_loop()
        response: asyncio.Future[bytes] = loop.create_future()
        self._response = response
        self._sent_s = loop.time()
        try:
            async with asyncio.timeout(limit_s):
                return await response
        except TimeoutError:
            self._notices.report_episode(
                f"timeout {name}",
                Level.ERROR,
                f"the board did not answer service {name} within {limit_s:g} s",
            )
            raise ServiceTimeoutError(
                f"the board did not answer {name} within {limit_s:g} s; check that its loop() is not busy "
                "and that the line is good"
            ) from None
        finally:
            self._response = None
            if response.cancelled() and self._line is line:
                self._quarantine_call()

    def _quarantine_call(self) -> None:
        self._earlier_call_ended.clear()
        self._quarantine = asyncio.get_running_loop().call_later(QUARANTINE_S, self._end_quarantine)
