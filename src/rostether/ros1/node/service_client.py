"""Calls a service: finds its server, connects to it, and sends one request for one answer."""

from __future__ import annotations

import asyncio
import contextlib

from rostether.errors import (
    ConfigError,
    GraphError,
    ProtocolError,
    RostetherError,
    ServiceCallError,
    ServiceUnavailableError,
    TransportError,
    TypeMismatchError,
    UnknownNameError,
)
from rostether.graph.service_calls import answer_within
from rostether.msgdef.interface import ServiceType
from rostether.ros1.environment import parse_rpc_uri
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.tcpros_connection import connect
from rostether.tcpros.handshake import check_server, client_fields, probe_fields
from rostether.tcpros.message_framing import encode_messages
from rostether.tcpros.service_framing import AnswerDecoder, ServiceAnswer

# How often to check for a missing service, as in rospy.
POLL_INTERVAL_S = 0.3


class ServiceClient:
    """Calls one service; a persistent client keeps its connection until it breaks.

    Calls of a persistent client wait for each other; other calls run concurrently.
    """

    def __init__(
        self,
        service: str,
        service_type: ServiceType,
        master: MasterClient,
        *,
        persistent: bool = False,
        limits: GraphLimits = DEFAULT_GRAPH_LIMITS,
    ) -> None:
        self.service = service
        self._type = service_type
        self._master = master
        self._persistent = persistent
        self._limits = limits
        self._request_fields = client_fields(
            service, service_type, caller_id=master.caller_id, persistent=persistent
        )
        self._kept: _CallConnection | None = None
        self._lock = asyncio.Lock()

    async def call(self, request: bytes, *, timeout_s: float | None = None) -> bytes:
        """Return the response.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError with the server's text,
        TypeMismatchError, MasterUnreachableError.
        """
        async with answer_within(self.service, timeout_s):
            if not self._persistent:
                return await self._call(await self._open(self._request_fields), request)
            async with self._lock:
                connection = self._reuse() or await self._open(self._request_fields)
                return await self._call(connection, request)

    async def wait_until_available(self, timeout_s: float | None = None) -> None:
        """Wait until a server answers. Raises ServiceUnavailableError after `timeout_s`."""
        reason = f"no node offers the service {self.service}"
        fields = probe_fields(self.service, caller_id=self._master.caller_id)
        try:
            async with asyncio.timeout(timeout_s):
                while True:
                    try:
                        (await self._open(fields)).close()
                    except RostetherError as error:
                        reason = str(error)
                    else:
                        return
                    await asyncio.sleep(POLL_INTERVAL_S)
        except TimeoutError:
            raise ServiceUnavailableError(f"{reason} (waited {timeout_s:g} s)") from None

    async def close(self) -> None:
        """Close a kept connection. Idempotent."""
        if self._kept is not None:
            self._kept.close()
            self._kept = None

    def _reuse(self) -> _CallConnection | None:
        kept, self._kept = self._kept, None
        return kept if kept is not None and kept.is_open else None

    async def _call(self, connection: _CallConnection, request: bytes) -> bytes:
        keep = False
        try:
            answer = await connection.call(request)
            keep = self._persistent
        except (ProtocolError, TransportError) as error:
            raise ServiceCallError(f"service {self.service}: {error}; see the log of its node") from error
        finally:
            if keep:
                self._kept = connection
            else:
                connection.close()
        if not answer.is_ok:
            # roscpp's servers send no text if their callback returns false.
            reason = answer.error_text or "no reason given; see the log of its node"
            raise ServiceCallError(f"service {self.service} responded with an error: {reason}")
        return answer.payload

    async def _open(self, fields: dict[str, str]) -> _CallConnection:
        def accept(answer: dict[str, str], transport: asyncio.Transport) -> _CallConnection:
            check_server(answer, self.service, self._type)
            return _CallConnection(transport, self._limits.message_bytes)

        try:
            uri = await self._master.lookup_service(self.service)
        except UnknownNameError:
            raise ServiceUnavailableError(
                f"no node offers the service {self.service}; start its node, or check the name"
            ) from None
        try:
            address = parse_rpc_uri(uri, scheme="rosrpc")
            connection = await connect(address.host, address.port, fields, accept)
        except TypeMismatchError:
            raise
        except (GraphError, TransportError, ProtocolError, ConfigError) as error:
            raise ServiceUnavailableError(
                f"service {self.service} is registered at {uri} but cannot be called ({error}); "
                "if its node has ended, `rostether node cleanup` removes it"
            ) from error
        assert isinstance(connection, _CallConnection)
        return connection


class _CallConnection(asyncio.Protocol):
    """A connection with one call at a time."""

    def __init__(self, transport: asyncio.Transport, max_message_bytes: int) -> None:
        self._transport = transport
        self._decoder = AnswerDecoder(max_message_bytes)
        self._answer: asyncio.Future[ServiceAnswer] | None = None
        self._is_lost = False

    @property
    def is_open(self) -> bool:
        return not self._is_lost and not self._transport.is_closing()

    async def call(self, request: bytes) -> ServiceAnswer:
        if not self.is_open:
            raise ProtocolError("the server closed the connection before the request")
        self._answer = asyncio.get_running_loop().create_future()
        self._transport.write(encode_messages([request]))
        try:
            return await self._answer
        finally:
            self._answer = None

    def close(self) -> None:
        self._transport.abort()

    def data_received(self, data: bytes) -> None:
        try:
            answers = self._decoder.feed(data)
        except ProtocolError as error:
            self._fail(error)
            return
        if not answers:
            return
        if self._answer is None or self._answer.done() or len(answers) > 1:
            # The answer belongs to no request of this client.
            self._fail(ProtocolError("the server sent an answer without a request"))
        else:
            self._answer.set_result(answers[0])

    def connection_lost(self, exc: Exception | None) -> None:
        self._is_lost = True
        self._fail(ProtocolError("the server closed the connection during the call"))

    def _fail(self, error: ProtocolError) -> None:
        if self._answer is not None and not self._answer.done():
            self._answer.set_exception(error)
        with contextlib.suppress(RuntimeError):
            self._transport.close()
