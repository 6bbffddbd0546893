"""The state of the radio at the host, read by AT commands when its port opens. Sans I/O."""

from __future__ import annotations

from rostether.transports.xbee.packets import (
    MAX_PAYLOAD_BYTES,
    MESH_PAYLOAD_BYTES,
    AtAnswer,
    encode_at,
    encode_packet,
)
from rostether.transports.xbee.send_queue import Packet

# A packet of a mesh has no signal strength. The radio is asked for it, for each board at most once a period.
SIGNAL_PERIOD_S = 5.0

_API_MODE = 2
_FRAME_ID = 1
# The API mode, the hops, and the bytes in a packet. The radio is ready after the answer to the last query.
_QUERIES = ("AP", "NH", "NP")


class HostRadio:
    """One radio from the opening of its port to its end; `is_ready` when packets can be sent."""

    def __init__(self) -> None:
        self.is_ready = False
        self.has_answered = False
        self.packet_bytes = MAX_PAYLOAD_BYTES
        self._is_mesh = False
        self._api_mode = _API_MODE
        self._asked_signal_s = float("-inf")

    def queries(self) -> bytes:
        """Return the frames that ask the radio for its mode and limits."""
        return b"".join(encode_at(command, frame_id=_FRAME_ID) for command in _QUERIES)

    def signal_query(self, now_s: float, board_count: int) -> bytes:
        """Return the frame that asks for the signal strength of the last packet, if it is due."""
        if now_s - self._asked_signal_s < SIGNAL_PERIOD_S / max(1, board_count):
            return b""
        self._asked_signal_s = now_s
        return encode_at("DB", frame_id=_FRAME_ID)

    def answered(self, answer: AtAnswer) -> int | None:
        """Handle an answer; return the signal strength in dBm, if it is one."""
        self.has_answered = True
        value = int.from_bytes(answer.value, "big") if answer.is_ok and answer.value else None
        match answer.command:
            case "AP" if value is not None:
                self._api_mode = value
            # Only a mesh has hops.
            case "NH" if value is not None:
                self._is_mesh = True
                self.packet_bytes = MESH_PAYLOAD_BYTES
            case "NP":
                # The largest packets of some radios would keep all boards waiting.
                self.packet_bytes = min(value or self.packet_bytes, MAX_PAYLOAD_BYTES)
                self.is_ready = True
            case "DB" if value is not None:
                return -value
        return None

    def encode(self, packet: Packet[int]) -> bytes:
        """Return the frame that sends a packet."""
        return encode_packet(
            packet.key,
            packet.payload,
            frame_id=packet.frame_id,
            is_mesh=self._is_mesh,
            limit_bytes=self.packet_bytes,
        )

    def problem(self, path: str, baud: int) -> str | None:
        """Return the radio's problem and its remedy, None if it answers correctly."""
        next_step = f"run `rostether xbee setup {path} --coordinator`"
        if not self.has_answered:
            mode = f"{baud} baud in API mode 2"
            return f"the XBee at {path} does not answer at {mode}; check the port, or {next_step}"
        if self._api_mode != _API_MODE:
            return f"the XBee at {path} is not in API mode 2; {next_step}"
        return None
