"""The Device: a Python program, for example on a Raspberry Pi, that joins ROS like a microcontroller."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Self

from msgspec.structs import replace

from rostether.device.endpoints import Endpoints
from rostether.device.line import DeviceLine
from rostether.device.parameters import DeviceParam, ParameterRequests
from rostether.errors import (
    ConfigError,
    TransportClosedError,
    TransportError,
    TransportTimeoutError,
    UnknownNameError,
)
from rostether.graph.ports import Level
from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.block_end import BlockClosable
from rostether.mechanisms.tasks import cancel_all
from rostether.msgdef.registry import Registry
from rostether.msgdef.search_waiting import definitions_searched
from rostether.rosserial.device_link import DeviceLink, DeviceLinkConfig
from rostether.rosserial.events import (
    DeviceEvent,
    MessagesReceived,
    ParameterReceived,
    ParameterTimedOut,
    StopReceived,
    TopicsRequested,
    Unconfigured,
)
from rostether.rosserial.frame import MAX_PAYLOAD_BYTES, encode_frame
from rostether.rosserial.packets import PUBLISHER_OVERHEAD_BYTES, LogLevel, encode_time
from rostether.rosserial.topic_id import TIME
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.transports.address import Address, TcpAddress, UdpAddress
from rostether.transports.address_parser import parse_address
from rostether.transports.opening import open_transport
from rostether.transports.transport import Transport

# Unlike a microcontroller, a program has memory for the largest message that fits in a frame.
PROGRAM_CONFIG = DeviceLinkConfig(
    max_subscribers=100,
    max_publishers=100,
    input_buffer_bytes=MAX_PAYLOAD_BYTES,
    output_buffer_bytes=MAX_PAYLOAD_BYTES + PUBLISHER_OVERHEAD_BYTES,
)
# Over UDP, a host detects the device by its first datagram, which is repeated because it may be lost.
_GREETING = encode_frame(TIME, encode_time(Time()))
_GREETING_PERIOD_S = 1.0
# A running host requests the topics within a second.
NO_HOST_WARNING_S = 5.0
_NO_CAUSE = "; start one: rostether serve"
_CLOSED = "the device was closed"

_LOG = logging.getLogger(__name__)


class Device(Endpoints, BlockClosable):
    """A rosserial device in Python; `async with` opens its line and keeps it open.

    `link` is a link address (tcp and udp connect to it), or an open transport, which is not reopened after it
    ends. Endpoints may be declared before or after the line opens. Raises ConfigError.
    """

    def __init__(
        self,
        link: str | Address | Transport,
        *,
        msg_paths: Sequence[Path | str] = (),
        store: TypeStore | None = None,
        config: DeviceLinkConfig = PROGRAM_CONFIG,
        backoff: Backoff | None = None,
        clock: Callable[[], float] | None = None,
    ) -> None:
        self._given: Transport | None = None
        self._address: Address | None = None
        if isinstance(link, str):
            link = parse_address(link)
        if isinstance(link, TcpAddress | UdpAddress):
            link = replace(link, connect=True)
        if isinstance(link, Address):
            if link.listens:
                raise ConfigError(f"{link} accepts many devices; use the address of a single line")
            self._address = link
        else:
            self._given = link
        self._backoff = backoff if backoff is not None else Backoff()
        self._clock = clock if clock is not None else asyncio.get_running_loop().time
        device_link = DeviceLink(config)
        super().__init__(
            store if store is not None else TypeStore(Registry.from_environment(msg_paths)),
            device_link,
            DeviceLine(device_link, self._handle_event, self._handle_loss, self._clock),
        )
        self._parameters = ParameterRequests()
        self._configured = asyncio.Event()
        # Why no host is connected, as the end of a sentence.
        self._cause = _NO_CAUSE
        self._keeper: asyncio.Task[None] | None = None
        self._is_closed = False

    async def __aenter__(self) -> Self:
        """Open the line; if that fails, retry in the background. Raises ConfigError."""
        # After this, topics of any type can be added without a search of folders.
        await definitions_searched(self._store.registry)
        self._is_closed = False
        for stream in self._streams:
            stream.begin()
        transport = await self._open()
        if transport is not None:
            self._line.attach(transport)
        self._keeper = asyncio.get_running_loop().create_task(self._keep_open(transport))
        return self

    async def close(self) -> None:
        """Close the line and fail all pending requests; waits for a host and loops over messages end.

        Idempotent.
        """
        if self._keeper is not None:
            await cancel_all(self._keeper)
        transport = self._line.transport
        self._line.detach()
        self._is_closed = True
        self._configured.set()
        self._fail_requests(_CLOSED)
        for server in self._servers:
            server.close()
        for stream in self._streams:
            stream.end()
        if transport is not None:
            await transport.wait_closed()

    @property
    def connected(self) -> bool:
        """Whether a host has requested the topics and still answers."""
        return self._line.transport is not None and self._link.is_configured

    async def wait_connected(self, timeout_s: float | None = None) -> None:
        """Wait until a host is connected; a long wait is logged.

        Raises TransportTimeoutError, and TransportClosedError if the device is closed.
        """
        if self.connected:
            return
        warning = asyncio.get_running_loop().call_later(NO_HOST_WARNING_S, self._warn_of_no_host)
        try:
            async with asyncio.timeout(timeout_s):
                while not self.connected:
                    if self._is_closed:
                        raise TransportClosedError(_CLOSED)
                    self._configured.clear()
                    await self._configured.wait()
        except TimeoutError:
            raise TransportTimeoutError(
                f"no host requested the topics within {timeout_s:g} s{self._cause}"
            ) from None
        finally:
            warning.cancel()

    def _warn_of_no_host(self) -> None:
        _LOG.warning("no host has requested the topics yet%s", self._cause)

    async def get_param(
        self, name: str, default: DeviceParam | None = None, *, timeout_s: float = 2.0
    ) -> DeviceParam:
        """Return a parameter's value from the host, or `default`, if given, for a missing one.

        A value is a number, a string, or a list of one of these types. Raises UnknownNameError,
        TransportTimeoutError if no host answers, LocalProtocolError for an invalid name or too many requests.
        """
        try:
            async with asyncio.timeout(timeout_s):
                await self.wait_connected()
                self._link.request_parameter(name, self._clock(), timeout_s=timeout_s)
                self._line.flush_soon()
                return await self._parameters.wait(name)
        except UnknownNameError:
            if default is None:
                raise
            return default
        except TransportTimeoutError:
            raise
        except TransportClosedError as error:
            raise TransportTimeoutError(f"parameter {name}: {error}") from None
        except TimeoutError:
            cause = "; check the line" if self.connected else self._cause
            raise TransportTimeoutError(
                f"no host answered for parameter {name} within {timeout_s:g} s{cause}"
            ) from None

    def _no_host_cause(self) -> str:
        return "" if self.connected else f": no host is connected{self._cause}"

    def log(self, level: Level, text: str) -> None:
        """Log on the host, which publishes it on /rosout; lost while the line is down."""
        if self._line.transport is not None:
            self._link.log(LogLevel[level.name], text)
            self._line.flush_soon()

    def now(self) -> Time:
        """Return the host's time; before the host has answered, the time since the line was opened."""
        return self._link.time(self._clock())

    async def _open(self) -> Transport | None:
        if self._address is None:
            return self._given
        try:
            return await open_transport(self._address)
        except TransportError as error:
            _LOG.info("%s; trying again", error)
            self._cause = f": {error}"
            return None

    async def _keep_open(self, transport: Transport | None) -> None:
        while True:
            if transport is not None:
                await self._serve_line(transport)
            if self._address is None:
                return
            await asyncio.sleep(self._backoff.next_delay_s())
            transport = await self._open()
            if transport is not None:
                self._line.attach(transport)

    async def _serve_line(self, transport: Transport) -> None:
        sends_greeting = isinstance(self._address, UdpAddress)
        while self._line.transport is transport:
            if sends_greeting and not self.connected:
                transport.write(_GREETING)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_GREETING_PERIOD_S if sends_greeting else None):
                    error = await self._line.wait_lost()
                    self._cause = _NO_CAUSE if error is None else f": {error}"
                    _LOG.info("%s", error if error is not None else "the line was closed")

    def _handle_event(self, event: DeviceEvent) -> None:
        match event:
            case MessagesReceived(topic_id, payloads):
                receive = self._receivers.get(topic_id)
                if receive is not None:
                    receive(payloads)
            case TopicsRequested():
                self._backoff.reset()
                self._cause = _NO_CAUSE
                self._configured.set()
            case ParameterReceived():
                self._parameters.answered(event)
            case ParameterTimedOut():
                self._parameters.timed_out(event)
            case Unconfigured() | StopReceived():
                _LOG.info("the host closed the connection")

    def _handle_loss(self) -> None:
        reopening = "; reopening it" if self._address is not None else ""
        self._fail_requests(f"the line to the host was lost{reopening}")

    def _fail_requests(self, reason: str) -> None:
        self._parameters.fail_all(reason)
        for client in self._clients:
            client.fail(reason)
