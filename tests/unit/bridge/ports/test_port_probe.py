"""Tests the decisions of the probe without I/O, on a line with the real speed of a UART model."""

from __future__ import annotations

import asyncio

import pytest

from rostether.bridge.ports.port_probe import probe_port
from rostether.errors import TransportClosedError, TransportError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.baud_probe import BoardFound, NoBoard
from rostether.rosserial.frame import encode_frame
from rostether.transports.transport import Receiver
from unit.bridge.doubles import FakeTransport
from unit.rosserial.uart_line import garbled

REQUEST = encode_frame(ids.TOPIC_REQUEST, b"")
ANSWER = encode_frame(ids.TIME, bytes(8))


class Line(FakeTransport):
    """A board at one baud rate, and a port that can be set to any rate except `refused`."""

    def __init__(self, baud: int, *, has_baud: bool = True, refused: tuple[int, ...] = ()) -> None:
        super().__init__(can_pause=False)
        self.board_baud = baud
        self.has_baud = has_baud
        self.baud = 0
        self.bauds: list[int] = []
        self.refused = refused
        self.released: bytes | None = None
        self.is_paused = False
        self.is_mute = False
        self.receiver: Receiver | None = None

    def start(self, receiver: Receiver) -> None:
        self.receiver = receiver

    def set_baud(self, baud: int) -> bool:
        self.bauds.append(baud)
        if baud in self.refused:
            return False
        self.baud = baud
        return True

    def release(self, unread: bytes = b"") -> None:
        self.receiver = None
        self.released = unread

    def pause_reading(self) -> None:
        self.is_paused = True

    def write(self, data: bytes | bytearray | memoryview) -> None:
        super().write(data)
        speed = self.baud if self.has_baud else self.board_baud
        if REQUEST in garbled(bytes(data), speed, self.board_baud):
            asyncio.get_running_loop().call_soon(self.answer)

    def answer(self) -> None:
        if self.receiver is not None and not self.is_mute:
            speed = self.baud if self.has_baud else self.board_baud
            self.receiver.data_received(garbled(ANSWER, self.board_baud, speed))


async def test_the_port_keeps_the_speed_and_the_received_bytes() -> None:
    line = Line(115200)
    assert await probe_port(line) == BoardFound(115200, 2, ANSWER)
    assert (line.baud, line.released, line.is_paused) == (115200, ANSWER, True)
    assert line.bauds == [57600, 115200]


async def test_the_last_speed_is_tried_first() -> None:
    line = Line(38400)
    await probe_port(line, known_baud=38400)
    assert line.bauds == [38400]


async def test_a_rate_that_the_port_does_not_support_is_skipped() -> None:
    line = Line(115200, refused=(57600,))
    assert await probe_port(line) == BoardFound(115200, 2, ANSWER)


async def test_a_pseudo_terminal_has_no_speed_to_search_for(monkeypatch: pytest.MonkeyPatch) -> None:
    line = Line(57600, has_baud=False)
    assert await probe_port(line, known_baud=9600) == BoardFound(57600, 2, ANSWER)
    monkeypatch.setattr("rostether.rosserial.baud_probe.BOOT_S", 0.1)
    monkeypatch.setattr("rostether.rosserial.baud_probe.PATIENT_DWELL_S", 0.1)
    silent = Line(57600, has_baud=False)
    silent.is_mute = True
    assert await probe_port(silent) == NoBoard(0)
    assert silent.released is None


async def test_a_port_that_goes_ends_the_probe() -> None:
    line = Line(1)
    probing = asyncio.ensure_future(probe_port(line))
    await asyncio.sleep(0)
    assert line.receiver is not None
    line.receiver.connection_lost(TransportClosedError("unplugged"))
    with pytest.raises(TransportError, match="unplugged"):
        await probing
