"""The command mode of a radio: `ATMY 1` and `ATID1331,CH0D,WR` are answered by OK, ERROR or a value."""

from __future__ import annotations

from collections.abc import Iterator

from rostether.simulation.xbee.registers import Registers

_EXIT = "CN"
# Longer than any line of commands; a line that never ends must not fill the memory.
_MAX_LINE_BYTES = 256


class CommandMode:
    """One session in command mode."""

    def __init__(self, registers: Registers) -> None:
        self.has_ended = False
        self._registers = registers
        self._line = bytearray()

    def receive(self, data: bytes) -> bytes:
        """Return the answers to the lines that the bytes complete, one for each command."""
        answers = bytearray()
        for byte in data:
            if byte != ord("\r"):
                self._line.append(byte)
                del self._line[:-_MAX_LINE_BYTES]
                continue
            line, self._line = self._line.decode("latin-1").strip().upper(), bytearray()
            for answer in self._answers(line):
                answers += answer.encode("ascii") + b"\r"
        return bytes(answers)

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
