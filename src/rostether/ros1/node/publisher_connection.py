"""The connection to one publisher: found with its slave API, and read while it is registered."""

from __future__ import annotations

import asyncio
import functools
import logging
from collections.abc import Callable, Sequence

from rostether.errors import ConfigError, GraphError, ProtocolError, TransportError, TypeMismatchError
from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.tasks import occurs_within
from rostether.ros1.tcpros_connection import ConnectionRecord, connect
from rostether.ros1.xmlrpc_client import XmlRpcClient
from rostether.tcpros.message_framing import MessageDecoder

# A publisher that restarts its server, or registered before it listens, is reachable again immediately.
FIRST_RETRY_S = 0.1

# Each retry to a publisher that has ended costs one refused connection; longer delays annoy users.
MAX_RETRY_S = 5.0

# Failures in a row before a report, after 0.7 s: a publisher that ends is unregistered by then.
UNREPORTED_FAILURES = 4

# A publisher that has ended closes its connections immediately; its last messages may still be in the socket.
# A publisher that keeps a connection open sends nothing more.
DRAIN_S = 1.0

# Messages passed on before other tasks run: more than fit into one read if they have 60 bytes. Empty messages
# have four bytes on the line, and all those of one read would take 0.1 s.
TURN_MESSAGES = 4096

# After this many times DRAIN_S, the connection of an unregistered publisher that still publishes is closed.
MAX_DRAINS = 10

_log = logging.getLogger("rostether.ros1")


class PublisherConnection(asyncio.Protocol):
    """Splits a publisher's data into messages, and passes on those of each chunk.

    `node_name` is the node in the publisher's header.
    """

    def __init__(
        self,
        transport: asyncio.Transport,
        record: ConnectionRecord,
        on_messages: Callable[[Sequence[bytes]], None],
        max_message_bytes: int,
        *,
        node_name: str = "",
    ) -> None:
        self.record = record
        self.node_name = node_name
        self.lost = asyncio.Event()
        self._transport = transport
        self._decoder = MessageDecoder(max_message_bytes)
        self._on_messages = on_messages
        self._loop = asyncio.get_running_loop()
        self._is_paused = False
        self._has_ended = False
        self._is_turn_due = False
        # Messages for later turns of the loop.
        self._waiting: list[bytes] = []
        # Data that was read before a pause took effect, such as a message right after the header.
        self._held: list[bytes] = []

    def data_received(self, data: bytes) -> None:
        """Pass on complete messages."""
        if self._is_paused or self._waiting or self._held:
            self._held.append(data)
            return
        payloads = self._decode(data)
        if len(payloads) > TURN_MESSAGES:
            self._waiting = payloads
            self._transport.pause_reading()
            self._pass_on_turn()
        elif payloads:
            self.record.message_count += len(payloads)
            self._on_messages(payloads)

    def connection_lost(self, exc: Exception | None) -> None:
        """Wake the waiting task, after the messages that wait for their turn."""
        self._has_ended = True
        if not (self._waiting or self._held):
            self.lost.set()

    def pause(self) -> None:
        """Stop reading. Idempotent."""
        if not self._is_paused:
            self._is_paused = True
            if not self._transport.is_closing():
                self._transport.pause_reading()

    def resume(self) -> None:
        """Read again. Idempotent."""
        if self._is_paused:
            self._is_paused = False
            if self._waiting or self._held:
                # Not now: a receiver may resume while it handles earlier messages.
                self._continue_soon()
            elif not self._transport.is_closing():
                self._transport.resume_reading()

    def _decode(self, data: bytes) -> list[bytes]:
        self.record.byte_count += len(data)
        try:
            return self._decoder.feed(data)
        except ProtocolError as error:
            _log.warning("%s from %s: %s; reconnecting", self.record.topic, self.record.peer, error)
            self._transport.abort()
            return []

    def _continue_soon(self) -> None:
        if not self._is_turn_due:
            self._is_turn_due = True
            self._loop.call_soon(self._continue)

    def _continue(self) -> None:
        """Pass on the messages of one turn; after the last turn, read again."""
        self._is_turn_due = False
        if self._is_paused:
            return
        if self._held and not self._waiting:
            self._waiting = self._decode(b"".join(self._held))
            self._held.clear()
        if self._waiting:
            self._pass_on_turn()
        elif self._has_ended:
            self.lost.set()
        elif not self._transport.is_closing():
            self._transport.resume_reading()

    def _pass_on_turn(self) -> None:
        payloads = self._waiting[:TURN_MESSAGES]
        del self._waiting[:TURN_MESSAGES]
        self.record.message_count += len(payloads)
        self._on_messages(payloads)
        self._continue_soon()

    def abort(self) -> None:
        """Close the connection immediately; no message is passed on afterwards."""
        self._waiting.clear()
        self._held.clear()
        self._transport.abort()


class PublisherLink:
    """Keeps one publisher connected: requests its address at the start and whenever the connection breaks.

    `accept` creates the connection from its header, as in `HandshakeProtocol`. `report` gets one line for
    users if the publisher is unreachable for some time, or if its type does not match; then there is no
    retry, because a publisher that changes its type registers again.
    """

    def __init__(
        self,
        uri: str,
        *,
        caller_id: str,
        request: dict[str, str],
        accept: Callable[[str, dict[str, str], asyncio.Transport], PublisherConnection],
        report: Callable[[str], None],
    ) -> None:
        self.uri = uri
        self.connection: PublisherConnection | None = None
        self._caller_id = caller_id
        self._request = request
        self._accept = accept
        self._report = report
        self._is_closed = False
        self._task = asyncio.ensure_future(self._run())

    @property
    def is_connected(self) -> bool:
        """Whether a connection is open, and this link was not closed."""
        return not self._is_closed and self.connection is not None and not self.connection.lost.is_set()

    async def drain(self) -> None:
        """Pass on what an ended publisher has sent until it closes the connection, then close permanently."""
        connection = self.connection
        for _ in range(MAX_DRAINS):
            if connection is None or not self.is_connected:
                break
            byte_count = connection.record.byte_count
            await occurs_within(connection.lost, DRAIN_S)
            if connection.record.byte_count == byte_count:
                break
        await self.close()

    async def close(self) -> None:
        """Close the connection permanently; no message is passed on afterwards."""
        self._is_closed = True
        self._task.cancel()
        await asyncio.wait((self._task,))

    async def _run(self) -> None:
        backoff = Backoff(first_s=FIRST_RETRY_S, limit_s=MAX_RETRY_S)
        failures = 0
        loop = asyncio.get_running_loop()
        while True:
            try:
                self.connection = await self._connect()
                failures = 0
                began_s = loop.time()
                await self.connection.lost.wait()
                if loop.time() - began_s > MAX_RETRY_S:
                    backoff.reset()
            except TypeMismatchError as error:
                self._report(str(error))
                return
            except (GraphError, TransportError, ProtocolError, ConfigError) as error:
                failures += 1
                if failures == UNREPORTED_FAILURES:
                    self._report(
                        f"{error}; still trying. If the node runs, check its ROS_IP or ROS_HOSTNAME; "
                        "otherwise remove it with `rostether node cleanup`"
                    )
            finally:
                if self.connection is not None:
                    self.connection.abort()
                    self.connection = None
            await asyncio.sleep(backoff.next_delay_s())

    async def _connect(self) -> PublisherConnection:
        async with closed_at_end(XmlRpcClient(self.uri, peer="the publisher")) as client:
            topic = self._request["topic"]
            code, text, answer = await client.call_status(
                "requestTopic", self._caller_id, topic, [["TCPROS"]]
            )
        if code != 1:
            raise GraphError(f"the publisher refused: {text}")
        match answer:
            case ["TCPROS", str(host), int(port), *_]:
                connection = await connect(
                    host, port, self._request, functools.partial(self._accept, self.uri)
                )
                assert isinstance(connection, PublisherConnection)
                return connection
        raise GraphError("the publisher does not offer TCPROS")
