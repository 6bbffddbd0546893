"""XBee radios: one at the host on a serial port, one transport for each board's address.

    board ── radio ──> radio at the host ── frames ──> peers ──> one transport for each board
    board <── radio <── radio at the host <── frames <── send queue <── writes

The radio at the host is in API mode 2. Boards with an address of 16 bits (MY) and of 64 bits (the radio's
own) can be mixed. 802.15.4 and DigiMesh have different frames for 64-bit addresses, so the host asks the
radio which of the two protocols it uses.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import TypeAlias

from rostether.errors import TransportError
from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.tasks import cancel_all, occurs_within
from rostether.transports.address import SerialAddress, XbeeAddress
from rostether.transports.link_quality import LinkQuality
from rostether.transports.peers import PeerTable, SharedMedium
from rostether.transports.transport import SmallWriter, Transport
from rostether.transports.xbee.frame import XbeeFrameDecoder
from rostether.transports.xbee.host_radio import HostRadio
from rostether.transports.xbee.packets import AtAnswer, RadioPacket, TransmitStatus, parse_report, status_text
from rostether.transports.xbee.radio_address import BROADCAST_ADDRESS, is_of_one_radio, show_radio_address
from rostether.transports.xbee.send_queue import Finished, SendQueue

_LOG = logging.getLogger(__name__)

# A radio answers within 0.1 s; nothing is sent before, because the kind of frame may depend on the answer.
ANSWER_LIMIT_S = 1.0
# A board that has lost its host sends nothing, so all boards are called; users expect them within 2 s.
CALL_PERIOD_S = 2.0

# Eight boards get their last bytes, which ask them to stop, in a tenth of a second.
DRAIN_LIMIT_S = 0.7

OpenSerial: TypeAlias = Callable[[SerialAddress], Awaitable[Transport]]


class XbeeListener(SmallWriter):
    """Receives from boards by radio, and creates a transport for each. `start` creates a listener.

    If the radio at the host is unplugged, all transports end. The port is opened again when the radio is
    back.
    """

    def __init__(
        self,
        address: XbeeAddress,
        on_transport: Callable[[Transport], None],
        open_serial: OpenSerial,
        call: bytes,
    ) -> None:
        self._call = call if not address.peers else b""
        self._xbee_address = address
        self._open_serial = open_serial
        self._backoff = Backoff(limit_s=1.0)
        self._loop = asyncio.get_running_loop()
        self._serial: Transport | None = None
        self._reopening: asyncio.Task[None] | None = None
        self._answer_limit: asyncio.TimerHandle | None = None
        self._status_limit: asyncio.TimerHandle | None = None
        self._next_call: asyncio.TimerHandle | None = None
        self._drained = asyncio.Event()
        self._is_closed = False
        self._forget_radio()
        medium = SharedMedium(
            str(address),
            send=self._send,
            show=lambda source: f"xbee {show_radio_address(source)}",
            write_buffer_bytes=lambda key: self._queue.waiting_bytes(key),
            quality_of=self._quality,
        )
        self.peers: PeerTable[int] = PeerTable(medium, on_transport, on_forget=self._forget)

    @classmethod
    async def start(
        cls,
        address: XbeeAddress,
        on_transport: Callable[[Transport], None],
        *,
        open_serial: OpenSerial,
        call: bytes = b"",
    ) -> XbeeListener:
        """Open the radio's port; `call` is broadcast to find boards, unless the address has `peers=`.

        Raises the errors of `open_serial`.
        """
        listener = cls(address, on_transport, open_serial, call)
        await listener._open()
        return listener

    @property
    def address(self) -> str:
        """The link address on which it listens."""
        return str(self._xbee_address)

    async def close(self) -> None:
        """Send the waiting data, stop listening and end all its transports. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            self.peers.end_all(None)
            self._radio.is_ready = True
            self._pump()
            await occurs_within(self._drained, DRAIN_LIMIT_S)
        self._cancel_timers()
        if self._reopening is not None:
            await cancel_all(self._reopening)
        if self._serial is not None:
            self._serial.close()
            await self._serial.wait_closed()

    def data_received(self, data: bytes) -> None:
        """Handle the frames of a chunk: packets go to the transports of their senders."""
        for frame in self._decoder.feed(data):
            match parse_report(frame):
                case RadioPacket() as packet:
                    self._packet_received(packet)
                case TransmitStatus() as status:
                    if (finished := self._queue.finished(status)) is not None:
                        self._finished(finished)
                case AtAnswer() as answer:
                    self._answered(answer)
        self._pump()

    def connection_lost(self, error: TransportError | None) -> None:
        """End all transports, and wait for the radio to come back."""
        self._serial = None
        self._drained.set()
        if self._is_closed:
            return
        what_happened = str(error or f"{self.address} is closed").partition(";")[0]
        _LOG.warning("%s; plug the radio in again", what_happened)
        self._cancel_timers()
        self.peers.end_all(f"is out of reach: {self.address} is disconnected")
        self._reopening = self._loop.create_task(self._reopen())

    async def _open(self) -> None:
        self._serial = await self._open_serial(
            SerialAddress(self._xbee_address.path, self._xbee_address.baud)
        )
        self._forget_radio()
        self._serial.start(self)
        self._write(self._radio.queries())
        self._answer_limit = self._loop.call_later(ANSWER_LIMIT_S, self._check_answer)
        for peer in self._xbee_address.peers:
            self.peers.add(peer, expires=False)
        if self._call:
            self._call_boards()

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

    def _forget_radio(self) -> None:
        self._decoder = XbeeFrameDecoder()
        self._radio = HostRadio()
        self._queue: SendQueue[int] = SendQueue(lambda: self._radio.packet_bytes)
        self._qualities: dict[int, LinkQuality] = {}
        self._drained.clear()
        self._last_source: int | None = None

    def _cancel_timers(self) -> None:
        for timer in (self._answer_limit, self._status_limit, self._next_call):
            if timer is not None:
                timer.cancel()
        self._answer_limit = self._status_limit = self._next_call = None

    def _quality(self, key: int) -> LinkQuality:
        return self._qualities.setdefault(key, LinkQuality())

    def _forget(self, key: int) -> None:
        self._queue.release(key)
        self._qualities.pop(key, None)

    def _packet_received(self, packet: RadioPacket) -> None:
        self._radio.has_answered = True
        # If the source is forged to be the broadcast address, a reply would reach all boards. While the
        # listener closes, nothing would end the transport of a new board.
        if self._is_closed or not is_of_one_radio(packet.source):
            return
        self.peers.receive(packet.source, packet.payload)
        # A board that was refused, because there are too many, has no link quality.
        if (quality := self._qualities.get(packet.source)) is None:
            return
        quality.count_received(packet.rssi_dbm)
        self._queue.note_received(packet.source)
        self._last_source = packet.source
        if packet.rssi_dbm is None:
            self._write(self._radio.signal_query(self._loop.time(), len(self._qualities)))

    def _answered(self, answer: AtAnswer) -> None:
        rssi_dbm = self._radio.answered(answer)
        if rssi_dbm is not None and self._last_source in self._qualities:
            self._qualities[self._last_source].rssi_dbm = rssi_dbm

    def _check_answer(self) -> None:
        self._answer_limit = None
        self._radio.is_ready = True
        problem = self._radio.problem(self._xbee_address.path, self._xbee_address.baud)
        if problem is not None:
            _LOG.warning("%s", problem)
        self._pump()

    def _send(self, key: int, data: bytes | bytearray | memoryview) -> None:
        if not self._queue.put(key, data) and (quality := self._qualities.get(key)) is not None:
            quality.count_sent("queue full", is_lost=True)
        self._pump()

    def _pump(self) -> None:
        if self._serial is None or not self._radio.is_ready:
            return
        frames = bytearray()
        for packet in self._queue.next_packets(self._loop.time()):
            frames += self._radio.encode(packet)
        self._write(frames)
        if self._is_closed and self._queue.is_empty:
            self._drained.set()
        due_s = self._queue.get_timer()
        if due_s is not None and self._status_limit is None:
            self._status_limit = self._loop.call_at(due_s, self._give_up)

    def _call_boards(self) -> None:
        if not self._queue.waiting_bytes(BROADCAST_ADDRESS):
            self._send(BROADCAST_ADDRESS, self._call)
        self._next_call = self._loop.call_later(CALL_PERIOD_S, self._call_boards)

    def _write(self, data: bytes | bytearray) -> None:
        if data and self._serial is not None:
            self._serial.write(data)

    def _give_up(self) -> None:
        self._status_limit = None
        for finished in self._queue.give_up(self._loop.time()):
            self._finished(finished)
        self._pump()

    def _finished(self, finished: Finished[int]) -> None:
        if (quality := self._qualities.get(finished.key)) is not None:
            if (status := finished.status) is None:
                quality.count_sent("no report", is_lost=True)
            else:
                quality.count_sent(
                    status_text(status.status), is_lost=not status.is_delivered, retries=status.retries
                )
