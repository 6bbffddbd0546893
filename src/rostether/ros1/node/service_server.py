"""The services of this node: their connections, and the calls on them."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable, Mapping
from contextvars import ContextVar

from rostether.errors import ProtocolError, RostetherError
from rostether.graph.callbacks import report_error
from rostether.graph.ports import ServiceHandler
from rostether.msgdef.interface import ServiceType
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.tcpros.handshake import Purpose, check_client, purpose_of, server_fields
from rostether.tcpros.header import encode_header
from rostether.tcpros.message_framing import MessageDecoder
from rostether.tcpros.service_framing import encode_error, encode_response

# The header of the client whose call a handler answers; rospy shows it to the program.
CALLER_FIELDS: ContextVar[Mapping[str, str]] = ContextVar("CALLER_FIELDS")


class ServiceServer:
    """Implements `graph.ports.ServiceServer`.

    The calls of one client are handled in order, those of several clients concurrently.
    """

    def __init__(
        self,
        service: str,
        service_type: ServiceType,
        handler: ServiceHandler,
        *,
        node_name: str,
        on_close: Callable[[ServiceServer], Awaitable[None]],
        limits: GraphLimits = DEFAULT_GRAPH_LIMITS,
    ) -> None:
        self.service = service
        self.type = service_type
        self._handler = handler
        self._limits = limits
        self._greeting = encode_header(server_fields(service, service_type, caller_id=node_name))
        self._on_close = on_close
        self._connections: set[ServiceConnection] = set()
        self._is_closed = False

    def accept(self, fields: Mapping[str, str], transport: asyncio.Transport) -> ServiceConnection:
        """Create the connection of a client's header. Raises TypeMismatchError."""
        check_client(fields, self.type)
        connection = ServiceConnection(
            transport,
            fields,
            greeting=self._greeting,
            answer=self._answer,
            on_lost=self._connections.discard,
            max_message_bytes=self._limits.message_bytes,
        )
        self._connections.add(connection)
        return connection

    async def close(self) -> None:
        """Unadvertise; pending calls fail. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            await self._on_close(self)
            await asyncio.gather(*(connection.close() for connection in self._connections))

    async def _answer(self, request: bytes) -> bytes:
        try:
            return encode_response(await self._handler(request))
        except RostetherError as error:
            return encode_error(str(error))
        except Exception as error:  # noqa: BLE001 - an error in a handler must not end the service
            report_error(f"handler of service {self.service}", error)
            return encode_error(f"error processing request: {error}")


class ServiceConnection(asyncio.Protocol):
    """One client: requests are answered in order. A handler finishes even if its client has disconnected."""

    def __init__(
        self,
        transport: asyncio.Transport,
        fields: Mapping[str, str],
        *,
        greeting: bytes,
        answer: Callable[[bytes], Awaitable[bytes]],
        on_lost: Callable[[ServiceConnection], None],
        max_message_bytes: int,
    ) -> None:
        self._transport = transport
        self._fields = fields
        self._purpose = purpose_of(fields)
        self._greeting = greeting
        self._answer = answer
        self._on_lost = on_lost
        self._decoder = MessageDecoder(max_message_bytes)
        self._requests: deque[bytes] = deque()
        self._task: asyncio.Task[None] | None = None
        self._is_lost = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Answer the header; a probe ends here."""
        self._transport.write(self._greeting)
        if self._purpose is Purpose.PROBE:
            self._transport.close()

    def data_received(self, data: bytes) -> None:
        """Handle requests; read no more of them until these are answered."""
        try:
            self._requests.extend(self._decoder.feed(data))
        except ProtocolError as error:
            self._transport.write(encode_error(str(error)))
            self._transport.close()
            return
        if self._requests and self._task is None:
            self._transport.pause_reading()
            self._task = asyncio.ensure_future(self._serve())
            self._task.add_done_callback(self._served)

    def eof_received(self) -> bool:
        """Keep the connection: a client that only closed its sending side still gets its answer."""
        return self._task is not None

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection, after its handler has finished."""
        self._is_lost = True
        self._requests.clear()
        if self._task is None:
            self._on_lost(self)

    async def close(self) -> None:
        """End the connection; a running call is canceled and its caller receives an error."""
        if self._task is not None:
            self._transport.write(encode_error("the service has been shut down"))
            self._task.cancel()
            await asyncio.wait((self._task,))
        self._transport.close()

    async def _serve(self) -> None:
        CALLER_FIELDS.set(self._fields)
        while self._requests:
            answer = await self._answer(self._requests.popleft())
            if self._is_lost:
                return
            self._transport.write(answer)
            if self._purpose is Purpose.CALL_ONCE:
                self._transport.close()
                return
            if self._requests:
                # A handler may answer without waiting, and one read may hold 60,000 requests.
                await asyncio.sleep(0)

    def _served(self, task: asyncio.Task[None]) -> None:
        self._task = None
        if self._is_lost:
            self._on_lost(self)
        elif not self._transport.is_closing():
            self._transport.resume_reading()
