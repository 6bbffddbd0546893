"""One simulated XBee radio, sans I/O: bytes on its serial port in and out, packets in the air in and out.

    AP=0   transparent: bytes become packets after RO characters of silence, or when a packet is full
           +++ with GT of silence before and after: command mode, until ATCN or CT of silence
    AP=1,2 frames of the API

Source: Digi, XBee 802.15.4 and DigiMesh User Guides, "Modes" and "API operation".
"""

from __future__ import annotations

from collections import deque

from msgspec import Struct

from rostether.simulation.xbee.at_commands import (
    NOT_SENT,
    REQUEST_BYTES,
    CommandMode,
    RemoteAnswer,
    RemoteCommand,
    build_response,
    parse_request,
)
from rostether.simulation.xbee.registers import BAUD_RATES, Model, Registers
from rostether.transports.xbee.frame import XbeeFrameDecoder, encode_frame

BROADCAST = 0xFFFF
# The serial receive buffer of series 1; bytes that arrive while it is full are lost without a report.
BUFFER_BYTES = 202
# The limit in API mode, where one packet of 100 bytes fills nearly half of that buffer.
_BUFFERED_PACKETS = 3
_SERIAL_OUT_BYTES = 16 * 1024

_BITS_PER_BYTE = 10
_GUARD_UNIT_S = 0.001
_UNUSED_SHORT = 0xFFFE
_NO_FRAME = 0
_DELIVERED = 0
_INVALID_COMMAND, _INVALID_VALUE = 2, 3
_NO_NUMBER = 0xFFFFFFFFFFFFFFFF


class Transmission(Struct, frozen=True):
    """A packet to send to a 16-bit address, or to one of 64 bits if `is_long`.

    With `remote`, it has an AT command or its answer instead of bytes.
    """

    destination: int
    is_long: bool
    payload: bytes
    frame_id: int = _NO_FRAME
    is_mesh_frame: bool = False
    remote: RemoteCommand | RemoteAnswer | None = None


class SimulatedRadio:
    """A radio with its serial number (its 64-bit address), at first with factory settings.

    `outgoing` are the packets to send; the first one is in the air.
    """

    def __init__(self, model: Model, serial_number: int) -> None:
        self.model = model
        self.serial_number = serial_number
        self.registers = Registers(model, serial_number)
        self.outgoing: deque[Transmission] = deque()
        self._serial_out = bytearray()
        self._text = bytearray()
        self._is_due = False
        self._due_s: float | None = None
        self._last_byte_s = float("-inf")
        self._pluses = 0
        self._command_mode: CommandMode | None = None
        self._decoder = XbeeFrameDecoder()
        self._decoder_mode = 2

    @property
    def baud(self) -> int:
        """The speed of its serial port."""
        return BAUD_RATES[self.registers["BD"]]

    @property
    def short_address(self) -> int | None:
        """The radio's 16-bit address, None if it has none."""
        address = self.registers["MY"] if "MY" in self.model.registers else BROADCAST
        return address if address < _UNUSED_SHORT else None

    def serial_to_send(self) -> bytes:
        """Return the bytes for its serial port, once."""
        data, self._serial_out = bytes(self._serial_out), bytearray()
        return data

    def get_timer(self) -> float | None:
        """Return when to call `handle_timer`; None if nothing is scheduled."""
        return self._due_s

    def serial_received(self, data: bytes, now_s: float) -> None:
        """Handle bytes from its serial port."""
        if self._command_mode is not None:
            self._receive_commands(data, now_s)
        elif self.registers["AP"]:
            self._receive_frames(data)
        else:
            self._receive_text(data, now_s)
        self._last_byte_s = now_s

    def handle_timer(self, now_s: float) -> None:
        """End a silence: send a packet, or enter or leave command mode."""
        if self._due_s is None or now_s < self._due_s:
            return
        self._due_s = None
        if self._command_mode is not None:
            self._leave_command_mode()
        elif self._pluses == 3:
            self._pluses = 0
            self._command_mode = CommandMode(self.registers)
            self._to_serial(b"OK\r")
            self._due_s = now_s + self._command_limit_s()
        else:
            self._text += b"+" * self._pluses
            self._pluses = 0
            self._is_due = True
            self._packetize()

    def radio_received(
        self, short_source: int | None, long_source: int, payload: bytes, rssi_dbm: int
    ) -> None:
        """Handle a packet for this radio."""
        self.registers.signal_dbm = rssi_dbm
        if not self.registers["AP"]:
            if self._command_mode is None:
                self._to_serial(payload)
            return
        if self.model.is_mesh:
            header = bytes((0x90, *long_source.to_bytes(8, "big"), 0xFF, 0xFE, 0x01))
        elif short_source is None:
            header = bytes((0x80, *long_source.to_bytes(8, "big"), -rssi_dbm, 0))
        else:
            header = bytes((0x81, *short_source.to_bytes(2, "big"), -rssi_dbm, 0))
        self._report(header + payload)

    def remote_received(
        self, short_source: int | None, long_source: int, remote: RemoteCommand | RemoteAnswer
    ) -> None:
        """Run an AT command from another radio and answer, or pass an answer to the host."""
        if isinstance(remote, RemoteAnswer):
            if self.registers["AP"]:
                self._report(build_response(remote, long_source, short_source))
            return
        status, value = self._run_at(remote.command, remote.value)
        if remote.is_applied:
            self.registers.apply()
        if remote.frame_id != _NO_FRAME:
            answer = RemoteAnswer(remote.frame_id, remote.command, status, value)
            self._send(Transmission(long_source, True, b"", remote=answer))

    def transmitted(self, packet: Transmission, status: int, retries: int) -> None:
        """Report the result of a packet, if the host wants it, and prepare the next one."""
        self._packetize()
        if packet.frame_id == _NO_FRAME or not self.registers["AP"]:
            return
        if isinstance(packet.remote, RemoteCommand):
            if status != _DELIVERED:
                lost = RemoteAnswer(packet.frame_id, packet.remote.command, NOT_SENT)
                self.remote_received(None, packet.destination if packet.is_long else _NO_NUMBER, lost)
        elif packet.is_mesh_frame:
            self._report(bytes((0x8B, packet.frame_id, 0xFF, 0xFE, min(retries, 0xFF), status, 0)))
        else:
            self._report(bytes((0x89, packet.frame_id, status)))

    def _receive_text(self, data: bytes, now_s: float) -> None:
        is_after_silence = now_s - self._last_byte_s >= self._guard_s()
        may_be_command = set(data) == {ord("+")} and (is_after_silence or self._pluses)
        if may_be_command and not self._text and self._pluses + len(data) <= 3:
            self._pluses += len(data)
            self._due_s = now_s + self._guard_s()
            return
        self._text += b"+" * self._pluses + data
        self._pluses = 0
        self._is_due |= self.registers["RO"] == 0
        self._packetize()
        del self._text[BUFFER_BYTES:]
        silence_s = self.registers["RO"] * _BITS_PER_BYTE / self.baud
        self._due_s = now_s + silence_s if self._text else None

    def _packetize(self) -> None:
        """Make a packet of the waiting bytes; while one is in the air, the rest collects in the buffer."""
        size = self.model.packet_bytes
        if self.outgoing or not (len(self._text) >= size or (self._is_due and self._text)):
            return
        payload = bytes(self._text[:size])
        del self._text[:size]
        self._is_due &= bool(self._text)
        high, low = self.registers["DH"], self.registers["DL"]
        is_long = bool(high) or (self.model.is_mesh and low != BROADCAST)
        self._send(Transmission(high << 32 | low, is_long, payload))

    def _send(self, packet: Transmission) -> None:
        if len(self.outgoing) < _BUFFERED_PACKETS:
            self.outgoing.append(packet)

    def _receive_commands(self, data: bytes, now_s: float) -> None:
        assert self._command_mode is not None
        self._to_serial(self._command_mode.receive(data))
        if self._command_mode.has_ended:
            self._leave_command_mode()
            self._due_s = None
        else:
            self._due_s = now_s + self._command_limit_s()

    def _leave_command_mode(self) -> None:
        self._command_mode = None
        self.registers.apply()

    def _receive_frames(self, data: bytes) -> None:
        mode = self.registers["AP"]
        if self._decoder_mode != mode:
            self._decoder = XbeeFrameDecoder(escaped=mode == 2)
            self._decoder_mode = mode
        for frame in self._decoder.feed(data):
            self._handle_frame(frame)

    def _handle_frame(self, frame: bytes) -> None:
        kind, frame_id = (frame[0], frame[1]) if len(frame) > 1 else (None, 0)
        match kind:
            case 0x08 | 0x09 if len(frame) >= 4:
                self._execute_at(frame_id, frame[2:4].decode("latin-1"), frame[4:])
                # A frame of type 0x09 waits for ATAC or for a frame of type 0x08.
                if kind == 0x08:
                    self.registers.apply()
            case 0x17 if len(frame) >= REQUEST_BYTES:
                remote = parse_request(frame)
                self._send(Transmission(remote.destination, remote.is_long, b"", frame_id, remote=remote))
            case 0x01 if len(frame) >= 5:
                self._queue_packet(frame_id, int.from_bytes(frame[2:4], "big"), frame[5:])
            case 0x00 if len(frame) >= 11:
                self._queue_packet(frame_id, int.from_bytes(frame[2:10], "big"), frame[11:], is_long=True)
            case 0x10 if len(frame) >= 14:
                destination = int.from_bytes(frame[2:10], "big")
                self._queue_packet(frame_id, destination, frame[14:], is_long=True, is_mesh_frame=True)

    def _queue_packet(
        self,
        frame_id: int,
        destination: int,
        payload: bytes,
        *,
        is_long: bool = False,
        is_mesh_frame: bool = False,
    ) -> None:
        is_broadcast = destination == BROADCAST
        packet = Transmission(destination, is_long and not is_broadcast, payload, frame_id, is_mesh_frame)
        # A mesh has only its own kinds of frames.
        if self.model.is_mesh and not is_mesh_frame:
            return
        if len(payload) > self.model.packet_bytes:
            self.transmitted(packet, 0x74, 0)
            return
        self._send(packet)

    def _execute_at(self, frame_id: int, command: str, value: bytes) -> None:
        status, answer = self._run_at(command, value)
        if frame_id != _NO_FRAME:
            self._report(bytes((0x88, frame_id)) + command.encode("latin-1") + bytes((status,)) + answer)

    def _run_at(self, command: str, value: bytes) -> tuple[int, bytes]:
        """Return the status of an AT command, and the value that it reads."""
        is_ok, answer = self.registers.execute(command, int.from_bytes(value, "big") if value else None)
        failed = _INVALID_VALUE if value else _INVALID_COMMAND
        return _DELIVERED if is_ok else failed, self.registers.as_bytes(command, answer)

    def _report(self, data: bytes) -> None:
        self._to_serial(encode_frame(data, escaped=self.registers["AP"] == 2))

    def _to_serial(self, data: bytes) -> None:
        if len(self._serial_out) + len(data) <= _SERIAL_OUT_BYTES:
            self._serial_out += data

    def _guard_s(self) -> float:
        return self.registers["GT"] * _GUARD_UNIT_S

    def _command_limit_s(self) -> float:
        return self.registers["CT"] * 0.1
