"""Calls to an XML-RPC server of a ROS graph, a master or a node, over connections that are kept."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeAlias, cast

from rostether.errors import GraphError, ProtocolError, RemoteProtocolError
from rostether.mechanisms.text import show_endpoint
from rostether.ros1.environment import connect_host, parse_rpc_uri
from rostether.ros1.long_work import run_in_slices
from rostether.transports.sockets import explain_reason
from rostether.xmlrpc.document_reader import DocumentReader
from rostether.xmlrpc.document_writer import DocumentWriter, call_steps
from rostether.xmlrpc.http_message import MAX_BODY_BYTES, HttpClientSide, HttpStatusError
from rostether.xmlrpc.values import FaultError, XmlRpcValue

StatusTriplet: TypeAlias = tuple[int, str, XmlRpcValue]

# A healthy master or node answers within milliseconds; on a busy single-board computer, within two seconds.
DEFAULT_TIMEOUT_S = 10.0
# More calls than this to one server at a time are rare; connections above it are closed after their call.
MAX_IDLE_CONNECTIONS = 16

# The text of a refusal becomes a line in the log; some servers send a traceback.
MAX_SHOWN_CHARS = 2000


class XmlRpcClient:
    """Calls the server at `uri` (`http://host:port/`). Raises ConfigError for an invalid URI.

    `peer` names the server in errors (`the ROS master`); `unreachable` is the error raised when no server
    answers. Calls may overlap; each then uses its own connection. `on_lost` is called when the server closes
    a connection that was kept for the next call: often it has just ended. `other_server_advice` ends the
    errors that are raised if another kind of server answers.
    """

    def __init__(
        self,
        uri: str,
        *,
        peer: str = "the node",
        unreachable: type[GraphError] = GraphError,
        timeout_s: float = DEFAULT_TIMEOUT_S,
        on_lost: Callable[[], None] | None = None,
        max_body_bytes: int = MAX_BODY_BYTES,
        other_server_advice: str = "",
    ) -> None:
        self.uri = uri
        self.peer = peer
        self._other_server_advice = other_server_advice
        self._unreachable = unreachable
        self._timeout_s = timeout_s
        self._on_lost = on_lost
        self._max_body_bytes = max_body_bytes
        address = parse_rpc_uri(uri)
        self._host, self._port, self._path = address.host, address.port, address.path
        self._idle: list[_Connection] = []
        self._is_closed = False

    async def call(self, method: str, *args: object) -> XmlRpcValue:
        """Return the method's value.

        Raises GraphError (or `unreachable`) when the server cannot be reached, is too slow, or sends a fault
        or an invalid answer; its `__cause__` is the OSError, if any. Raises SerializationError when an
        argument cannot be sent.
        """
        try:
            writer = DocumentWriter()
            await run_in_slices(call_steps(writer, method, args))
            # The time limit is for the server. It does not include the time that this process needs to encode
            # and decode large values.
            async with asyncio.timeout(self._timeout_s):
                answer = await self._exchange(writer.document())
            reader = DocumentReader(answer)
            await run_in_slices(reader.steps())
            return reader.response()
        except TimeoutError:
            raise self._unreachable(
                f"{self.peer} at {self.uri} did not answer {method} in {self._timeout_s:g} s; check that it "
                "does not hang"
            ) from None
        except (OSError, UnicodeError) as error:
            reason = explain_reason(error)
            raise self._unreachable(
                f"{self.peer} at {self.uri} cannot be reached ({reason}); check that it runs there"
            ) from error
        except FaultError as error:
            raise GraphError(
                f"{self.peer} at {self.uri} refused {method}: {error.text[:MAX_SHOWN_CHARS]}"
            ) from error
        except HttpStatusError as error:
            kind = self.peer.replace("the ", "a ", 1)
            raise GraphError(
                f"{self.uri} is not {kind}: it answered {method} with {error}{self._other_server_advice}"
            ) from error
        except ProtocolError as error:
            raise GraphError(
                f"{self.peer} at {self.uri} sent an invalid answer to {method}: {error}"
            ) from error

    async def call_status(self, method: str, *args: object) -> StatusTriplet:
        """Call a ROS method and return its `(code, status message, value)`. Raises the same errors as `call`.

        Code 1 is success, 0 failure, -1 the caller's error; the value counts only with code 1.
        """
        answer = await self.call(method, *args)
        if not (isinstance(answer, list) and len(answer) == 3 and isinstance(answer[0], int)):
            raise GraphError(
                f"{self.peer} at {self.uri} answered {method} without [code, message, value]"
                f"{self._other_server_advice}"
            )
        text = answer[1][:MAX_SHOWN_CHARS] if isinstance(answer[1], str) else ""
        return answer[0], text, answer[2]

    def disconnect(self) -> None:
        """Close the connections that are not in use; a later call opens a new one."""
        idle, self._idle = self._idle, []
        for connection in idle:
            connection.close()

    async def close(self) -> None:
        """Disconnect permanently; connections in use are closed after their call. Idempotent."""
        self._is_closed = True
        self.disconnect()

    def _lost(self, connection: _Connection) -> None:
        if connection in self._idle:
            self._idle.remove(connection)
            if self._on_lost is not None:
                self._on_lost()

    async def _exchange(self, body: bytes) -> bytes:
        while self._idle:
            connection = self._idle.pop()
            if connection.is_open:
                try:
                    return await self._exchange_on(connection, body)
                except (OSError, RemoteProtocolError):
                    # The server may have closed a kept connection while our request was on its way.
                    if connection.has_answer_begun:
                        raise
                    break
        loop = asyncio.get_running_loop()
        host_header = show_endpoint(self._host, self._port)
        _, connection = await loop.create_connection(
            lambda: _Connection(
                HttpClientSide(host_header, path=self._path, max_body_bytes=self._max_body_bytes), self._lost
            ),
            connect_host(self._host),
            self._port,
        )
        return await self._exchange_on(connection, body)

    async def _exchange_on(self, connection: _Connection, body: bytes) -> bytes:
        try:
            answer = await connection.exchange(body)
        except BaseException:
            connection.close()
            raise
        if connection.is_open and not self._is_closed and len(self._idle) < MAX_IDLE_CONNECTIONS:
            self._idle.append(connection)
        else:
            connection.close()
        return answer


class _Connection(asyncio.Protocol):
    """One TCP connection with at most one exchange in progress."""

    def __init__(self, http: HttpClientSide, on_lost: Callable[[_Connection], None]) -> None:
        self._http = http
        self._on_lost = on_lost
        self._transport: asyncio.Transport | None = None
        self._answer: asyncio.Future[bytes] | None = None
        self._is_lost = False

    @property
    def is_open(self) -> bool:
        return not self._is_lost and self._http.is_reusable

    @property
    def has_answer_begun(self) -> bool:
        return self._http.has_answer_begun

    async def exchange(self, body: bytes) -> bytes:
        assert self._transport is not None
        if self._is_lost:
            raise ConnectionResetError("connection closed")
        self._answer = asyncio.get_running_loop().create_future()
        self._transport.write(self._http.send_request(body))
        try:
            return await self._answer
        finally:
            self._answer = None

    def close(self) -> None:
        if self._transport is not None:
            self._transport.abort()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        # uvloop's transports are not subclasses of asyncio's.
        self._transport = cast(asyncio.Transport, transport)

    def data_received(self, data: bytes) -> None:
        self._feed(data)

    def eof_received(self) -> None:
        self._feed(b"")
        self._is_lost = True

    def connection_lost(self, exc: Exception | None) -> None:
        self._is_lost = True
        if self._answer is not None and not self._answer.done():
            self._answer.set_exception(exc or ConnectionResetError("connection closed"))
        self._on_lost(self)

    def _feed(self, data: bytes) -> None:
        if self._answer is None or self._answer.done():
            # No call is waiting: the server closes a kept connection, or sends data without a request.
            self.close()
            return
        try:
            body = self._http.receive_data(data)
        except RemoteProtocolError as error:
            self._answer.set_exception(error)
            return
        if body is not None:
            self._answer.set_result(body)
