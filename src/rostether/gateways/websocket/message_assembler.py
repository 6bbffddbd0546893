"""Joins the frames of fragmented WebSocket messages."""

from __future__ import annotations

from websockets.frames import Frame, Opcode


class MessageAssembler:
    """Collects the data frames of one connection; the library has checked their order and total size."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._is_text = False

    def receive_frame(self, frame: Frame) -> str | bytes | None:
        """Return the message that a frame completes, else None. Raises UnicodeDecodeError."""
        if frame.opcode in (Opcode.TEXT, Opcode.BINARY):
            self._parts = [bytes(frame.data)]
            self._is_text = frame.opcode is Opcode.TEXT
        elif frame.opcode is Opcode.CONT:
            self._parts.append(bytes(frame.data))
        else:
            return None
        if not frame.fin:
            return None
        data = self._parts[0] if len(self._parts) == 1 else b"".join(self._parts)
        self._parts = []
        return data.decode() if self._is_text else data
