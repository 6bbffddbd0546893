"""A service of the graph that the board calls. The board's call blocks its sketch until a response comes.

The established device library waits without a limit, and the protocol cannot report that a call failed. So
every request gets a response: the service's, or one whose fields are all zero, with a log line of the reason.
"""

from __future__ import annotations

import asyncio
from collections import deque

from rostether.bridge.endpoint.board_line import BoardLine, stop_receiving
from rostether.bridge.reporter import Notices, reason_of
from rostether.bridge.settings import BridgeSettings
from rostether.errors import LocalProtocolError
from rostether.graph.ports import Graph, Level, ListsClients, ServiceClient
from rostether.rosserial.events import ServiceAnnounced
from rostether.rosserial.frame import MAX_PAYLOAD_BYTES
from rostether.serde.store import TypeStore

# A board waits for each response before it calls again; more than a few waiting requests are damage.
MAX_WAITING_REQUESTS = 8


class ServiceClientEndpoint:
    """One service that the board calls."""

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
        self._zero_response = store.codec(self._type.response.name).encode({})
        self._graph = graph
        self._notices = notices
        self._settings = settings
        self._listed: ServiceClient | None = None
        self._line: BoardLine | None = None
        self._requests: deque[bytes] = deque()
        self._calling: asyncio.Task[None] | None = None

    def attach(self, line: BoardLine, info: ServiceAnnounced) -> None:
        """Handle the requests of a connection."""
        self.detach()
        self.info = info
        self._line = line
        line.receivers[info.request.topic_id] = self.receive

    def detach(self) -> None:
        """Release the connection; the response to a pending call is dropped."""
        if self._line is not None:
            stop_receiving(self._line, self.info.request.topic_id, self.receive)
            self._line = None
        self._requests.clear()
        if self._calling is not None:
            self._calling.cancel()
            self._calling = None

    def __repr__(self) -> str:
        return f"<service client {self.info.name} [{self.info.type}]>"

    async def open(self) -> None:
        """Check that the name is legal, and list the client where the graph lists clients.

        Raises InvalidNameError, GraphError, DefinitionError.
        """
        self._graph.resolve(self.info.name)
        if isinstance(self._graph, ListsClients):
            self._listed = await self._graph.list_client(self.info.name, self._type)

    async def close(self) -> None:
        """Remove the client from the graph."""
        listed, self._listed = self._listed, None
        if listed is not None:
            await listed.close()

    def receive(self, payloads: list[bytes]) -> None:
        """Handle requests from the board."""
        line = self._line
        if line is None:
            return
        for payload in payloads:
            if len(self._requests) >= MAX_WAITING_REQUESTS:
                self.dropped_count += 1
                self._report("the board sends requests faster than they are answered; dropped one")
            else:
                # From now on, time answers are held back: one before the response would end the board's wait.
                line.call_started()
                self._requests.append(payload)
        if self._requests and self._calling is None:
            self._calling = asyncio.get_running_loop().create_task(self._serve(line))

    async def _serve(self, line: BoardLine) -> None:
        while self._requests and self._line is line:
            try:
                response = await self._call(self._requests.popleft())
                if self._line is line:
                    self._answer(line, response)
            finally:
                line.call_finished()
        if self._calling is asyncio.current_task():
            self._calling = None

    async def _call(self, request: bytes) -> bytes:
        if not self._request_layout.accepts(request):
            self.misfit_count += 1
            self._report(f"the request is damaged: {self._request_layout.explain(request)}")
            return self._zero_response
        timeout_s = self._settings.client_call_timeout_s
        try:
            # The second limit is for a graph that ignores the first.
            async with asyncio.timeout(timeout_s + 1.0):
                response = await self._graph.call_service(
                    self.info.name, self._type, request, timeout_s=timeout_s
                )
        except TimeoutError:
            self._report(f"no response within {timeout_s:g} s; the board gets an empty response")
            return self._zero_response
        except Exception as error:  # noqa: BLE001 - the board waits, and calls again
            self._report(f"{reason_of(error)}; the board gets an empty response")
            return self._zero_response
        # A longer one is refused later: checking a response of many MB would block all boards.
        if len(response) <= MAX_PAYLOAD_BYTES and not self._response_layout.accepts(response):
            self._report(f"{self._response_layout.explain(response)}; the board gets an empty response")
            return self._zero_response
        self.message_count += 1
        return response

    def _answer(self, line: BoardLine, response: bytes) -> None:
        topic_id = self.info.response.topic_id
        try:
            line.outbox.answer(topic_id, response)
        except LocalProtocolError as error:
            self._report(f"{error}; the board gets an empty response")
            try:
                line.outbox.answer(topic_id, self._zero_response)
            except LocalProtocolError:
                self.dropped_count += 1

    def _report(self, reason: str) -> None:
        self._notices.report_episode(
            f"call {self.info.name}", Level.ERROR, f"the board's call of {self.info.name} failed: {reason}"
        )
