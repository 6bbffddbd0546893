"""The frames of a client: joins fragmented messages, and decides whether the client is still connected."""

from __future__ import annotations

from websockets.frames import Frame, Opcode


class MessageAssembler:
    """Collects the data frames of one connection; the library has checked their order and total size."""

    def __init__(self) -> None:
        # Not a list: a client may send a message in frames of one byte, or in empty ones.
        self.incomplete: bytes | bytearray = b""
        self._is_text = False

    def receive_frame(self, frame: Frame) -> str | bytes | None:
        """Return the message that a frame completes, else None. Raises UnicodeDecodeError."""
        if frame.opcode in (Opcode.TEXT, Opcode.BINARY):
            self.incomplete = bytes(frame.data)
            self._is_text = frame.opcode is Opcode.TEXT
        elif frame.opcode is Opcode.CONT:
            if isinstance(self.incomplete, bytes):
                self.incomplete = bytearray(self.incomplete)
            self.incomplete += frame.data
        else:
            return None
        if not frame.fin:
            return None
        data, self.incomplete = bytes(self.incomplete), b""
        return data.decode() if self._is_text else data


class PingWatch:
    """Counts unanswered pings; beyond `allowed`, a client that reads no data has disconnected."""

    def __init__(self, allowed: int) -> None:
        self._allowed = allowed
        self._unanswered = 0
        self._unsent_bytes = 0

    def received(self) -> None:
        """Record a frame of the client: it counts as the answer to all pings."""
        self._unanswered = 0

    def is_lost(self, unsent_bytes: int, *, is_reading: bool) -> bool:
        """Return whether the client has disconnected; if not, count the ping that is sent next."""
        has_read = unsent_bytes != self._unsent_bytes
        self._unsent_bytes = unsent_bytes
        # A client that still reads is alive, even if its pong is late. The pong of a paused client cannot be
        # read here.
        if self._unanswered >= self._allowed and is_reading and not has_read:
            return True
        self._unanswered += 1
        return False
