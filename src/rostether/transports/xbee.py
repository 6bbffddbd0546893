"""XBee series 1 radios: one coordinator on a serial port, one transport for each board's 16-bit address."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import TypeAlias

from rostether.errors import TransportClosedError, TransportError
from rostether.mechanisms.backoff import Backoff
from rostether.transports.address import SerialAddress, XbeeAddress
from rostether.transports.peers import IDLE_LIMIT_S, MAX_PEERS, PeerTable
from rostether.transports.transport import Transport
from rostether.transports.xbee_frame import MAX_PAYLOAD_BYTES, XbeeFrameDecoder, encode_tx

_LOG = logging.getLogger(__name__)

# At 57600 baud ten seconds of output; what the radio cannot take by then is stale.
_SEND_LIMIT_BYTES = 64 * 1024

OpenSerial: TypeAlias = Callable[[SerialAddress], Awaitable[Transport]]


class XbeeListener:
    """Receives from boards by radio and makes a transport of each; made by `start`.

    When the coordinator is unplugged all its transports end, and the port is opened again when it is back.
    """

    def __init__(
        self,
        address: XbeeAddress,
        on_transport: Callable[[Transport], None],
        open_serial: OpenSerial,
        backoff: Backoff,
        max_peers: int,
        idle_limit_s: float,
    ) -> None:
        self._xbee_address = address
        self._open_serial = open_serial
        self._backoff = backoff
        self._decoder = XbeeFrameDecoder()
        self._serial: Transport | None = None
        self._reopening: asyncio.Task[None] | None = None
        self._closed = False
        self.peers: PeerTable[int] = PeerTable(
            str(address),
            on_transport,
            send=self._send,
            show=lambda source: f"xbee {source:#06x} at {address.path}",
            write_buffer_bytes=self._write_buffer_bytes,
            max_peers=max_peers,
            idle_limit_s=idle_limit_s,
        )

    @classmethod
    async def start(
        cls,
        address: XbeeAddress,
        on_transport: Callable[[Transport], None],
        *,
        open_serial: OpenSerial,
        backoff: Backoff | None = None,
        max_peers: int = MAX_PEERS,
        idle_limit_s: float = IDLE_LIMIT_S,
    ) -> XbeeListener:
        """Open the coordinator. Raises TransportOpenError as a serial port does."""
        listener = cls(
            address, on_transport, open_serial, backoff or Backoff(limit_s=1.0), max_peers, idle_limit_s
        )
        await listener._open()
        return listener

    @property
    def address(self) -> str:
        """Where it listens."""
        return str(self._xbee_address)

    async def close(self) -> None:
        """Stop listening and end all its transports. Idempotent."""
        self._closed = True
        self.peers.end_all(None)
        if self._reopening is not None:
            self._reopening.cancel()
            await asyncio.gather(self._reopening, return_exceptions=True)
        if self._serial is not None:
            self._serial.close()
            await self._serial.wait_closed()

    def data_received(self, data: bytes) -> None:
        """Deliver the packets in a chunk to the transports of their senders."""
        for packet in self._decoder.feed(data):
            self.peers.receive(packet.source, packet.payload)

    def connection_lost(self, error: TransportError | None) -> None:
        """End all transports, and wait for the coordinator to come back."""
        self._serial = None
        if self._closed:
            return
        _LOG.warning("%s", error)
        self.peers.end_all(error if error is not None else TransportClosedError(f"{self.address} closed"))
        self._reopening = asyncio.get_running_loop().create_task(self._reopen())

    def pause_writing(self) -> None:
        """Notify every peer that the coordinator accepts no more bytes."""
        self.peers.pause_writing()

    def resume_writing(self) -> None:
        """Notify every peer that the coordinator accepts bytes again."""
        self.peers.resume_writing()

    async def _open(self) -> None:
        self._serial = await self._open_serial(
            SerialAddress(self._xbee_address.path, self._xbee_address.baud)
        )
        self._decoder = XbeeFrameDecoder()
        self._serial.start(self)
        for peer in self._xbee_address.peers:
            self.peers.add(peer, expires=False)

    async def _reopen(self) -> None:
        while True:
            await asyncio.sleep(self._backoff.next_delay_s())
            try:
                await self._open()
            except TransportError:
                continue
            self._backoff.reset()
            _LOG.info("%s is back", self.address)
            return

    def _send(self, key: int, data: bytes | bytearray | memoryview) -> None:
        serial = self._serial
        if serial is None or serial.write_buffer_bytes > _SEND_LIMIT_BYTES:
            return
        frames = bytearray()
        for start in range(0, len(data), MAX_PAYLOAD_BYTES):
            frames += encode_tx(key, bytes(data[start : start + MAX_PAYLOAD_BYTES]))
        serial.write(frames)

    def _write_buffer_bytes(self) -> int:
        return self._serial.write_buffer_bytes if self._serial is not None else 0
