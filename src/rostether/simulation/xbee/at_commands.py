"""AT commands: in a radio's command mode, and for other radios.

In command mode, `ATMY 1` and `ATID1331,CH0D,WR` are answered by OK, ERROR or a value. Commands for other
radios are the frames 0x17 and 0x97 of the API, and the packets between radios:

    0x17  frame id, 64-bit address, 16-bit address, options, command, value
    0x97  frame id, 64-bit address, 16-bit address, command, status, value

Source: Digi, XBee 802.15.4 and DigiMesh User Guides, "Remote AT Command Request", "Remote Command Response".
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rostether.simulation.xbee.registers import Registers

_EXIT = "CN"
# Longer than any line of commands; a line that never ends must not fill the memory.
_MAX_LINE_BYTES = 256

# The shortest frame of type 0x17.
REQUEST_BYTES = 15
# The status of a response if the request was not acknowledged.
NOT_SENT = 4

# With these values in the 64-bit field, the address is in the 16-bit field.
_USES_SHORT = (0xFFFFFFFFFFFFFFFF, 0xFFFFFFFFFFFFFFFE)
_NO_SHORT = b"\xff\xfe"
_APPLY = 0x02


class CommandMode:
    """One session in command mode."""

    def __init__(self, registers: Registers) -> None:
        self.has_ended = False
        self._registers = registers
        self._line = b""

    def receive(self, data: bytes) -> bytes:
        """Return the answers to the lines that the bytes complete, one for each command."""
        *lines, rest = (self._line + data).split(b"\r")
        self._line = rest[-_MAX_LINE_BYTES:]
        texts = (line[-_MAX_LINE_BYTES:].decode("latin-1").strip().upper() for line in lines)
        return b"".join(f"{answer}\r".encode() for text in texts for answer in self._answers(text))

    def _answers(self, line: str) -> Iterator[str]:
        if not line.startswith("AT"):
            yield "ERROR"
            return
        if line == "AT":
            yield "OK"
            return
        for command in line.removeprefix("AT").split(","):
            name, text = command[:2], command[2:].strip()
            try:
                value = int(text, 16) if text else None
            except ValueError:
                yield "ERROR"
                return
            is_ok, answer = self._registers.execute(name, value)
            self.has_ended |= is_ok and name == _EXIT
            yield "ERROR" if not is_ok else "OK" if answer is None else f"{answer:X}"
            if not is_ok:
                return


class RemoteCommand(NamedTuple):
    """An AT command for another radio."""

    frame_id: int
    destination: int
    is_long: bool
    is_applied: bool
    command: str
    value: bytes


class RemoteAnswer(NamedTuple):
    """The answer of the other radio."""

    frame_id: int
    command: str
    status: int
    value: bytes = b""


def parse_request(frame: bytes) -> RemoteCommand:
    """Return the command of a frame of type 0x17, which has at least `REQUEST_BYTES`."""
    long, short = int.from_bytes(frame[2:10], "big"), int.from_bytes(frame[10:12], "big")
    is_long = long not in _USES_SHORT
    command = frame[13:15].decode("latin-1")
    return RemoteCommand(
        frame[1], long if is_long else short, is_long, bool(frame[12] & _APPLY), command, frame[15:]
    )


def build_response(answer: RemoteAnswer, long_source: int, short_source: int | None) -> bytes:
    """Return a frame of type 0x97."""
    short = _NO_SHORT if short_source is None else short_source.to_bytes(2, "big")
    return b"".join(
        (
            bytes((0x97, answer.frame_id)),
            long_source.to_bytes(8, "big"),
            short,
            answer.command.encode("latin-1"),
            bytes((answer.status,)),
            answer.value,
        )
    )
