"""Joins the frames of fragmented WebSocket messages."""

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
