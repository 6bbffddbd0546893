from __future__ import annotations

import asyncio
import json

import pytest

from rostether.errors import PeerClosedError, RemoteProtocolError, TransportClosedError
from rostether.transports.address import WebAddress
from rostether.transports.transport import HIGH_WATER_BYTES
from rostether.transports.web import (
    ALIVE_LIMIT_S,
    HELLO_LIMIT_S,
    WINDOW_BYTES,
    WebTransport,
)
from rostether.transports.web_boards import WebBoards
from rostether.transports.web_hello import read_hello
from unit.bridge.virtual_time import on_virtual_time
from unit.transports.recorder import Recorder


class Page:
    """The connection of a page, as far as a transport sees it."""

    def __init__(self, boards: WebBoards) -> None:
        self.sent = bytearray()
        self.texts: list[str] = []
        self.closed: tuple[int, str] | None = None
        self.is_read = True
        self.transport = boards.open(self)

    def connect(self, name: str = "uno", key: str = "key-of-uno") -> None:
        self.transport.received(json.dumps({"op": "connect", "name": name, "key": key, "baud": 115200}))

    def report(self, written_bytes: int) -> None:
        self.transport.received(json.dumps({"op": "written", "bytes": written_bytes}))

    def send(self, *messages: str | bytes) -> None:
        for each in messages:
            if isinstance(each, str):
                self.texts.append(each)
            else:
                self.sent += each

    def pause_reading(self) -> None:
        self.is_read = False

    def resume_reading(self) -> None:
        self.is_read = True

    def close(self, code: int, reason: str = "") -> None:
        self.closed = (code, reason)

    def abort(self) -> None:
        self.closed = (1006, "")


class Bridge:
    """Serves all boards at once."""

    def __init__(self, max_boards: int = 4) -> None:
        self.boards = WebBoards(max_boards)
        self.served: list[tuple[WebTransport, Recorder]] = []
        self.boards.listen(WebAddress(ns="lab"), self._serve)

    def _serve(self, transport: WebTransport) -> None:
        recorder = Recorder()
        self.served.append((transport, recorder))
        transport.start(recorder)


@on_virtual_time
async def test_bytes_pass_both_ways() -> None:
    bridge = Bridge()
    page = Page(bridge.boards)
    page.connect()
    page.transport.received(b"early")
    transport, recorder = bridge.served[0]
    assert transport.address == WebAddress(name="web_uno", ns="lab", baud=115200)
    assert page.texts == ['{"op":"connected"}']
    await recorder.until_received(b"early")
    page.transport.received(b" late")
    await recorder.until_received(b"early late")
    transport.write(b"to the board")
    assert page.sent == b"to the board"
    assert transport.write_buffer_bytes == 12
    page.report(12)
    assert transport.write_buffer_bytes == 0


@on_virtual_time
async def test_only_a_window_is_sent_ahead_of_the_port() -> None:
    bridge = Bridge()
    page = Page(bridge.boards)
    page.connect()
    transport, recorder = bridge.served[0]
    data = bytes(range(256)) * 400
    transport.write(data)
    assert len(page.sent) == WINDOW_BYTES
    assert len(data) > HIGH_WATER_BYTES
    assert recorder.write_pauses == [True]
    while transport.write_buffer_bytes:
        page.report(len(page.sent))
    assert page.sent == data
    assert recorder.write_pauses == [True, False]


@on_virtual_time
async def test_a_page_that_does_not_report_is_disconnected_within_5_seconds() -> None:
    bridge = Bridge()
    page = Page(bridge.boards)
    page.connect()
    loop = asyncio.get_running_loop()
    for _ in range(10):
        await asyncio.sleep(1.0)
        page.report(0)
    alive_s = loop.time()
    error = await bridge.served[0][1].until_lost()
    assert isinstance(error, TransportClosedError)
    assert "its page does not answer" in str(error)
    assert ALIVE_LIMIT_S < loop.time() - alive_s < 5.0
    assert page.closed is not None


@on_virtual_time
async def test_a_page_is_not_disconnected_while_its_messages_are_not_read() -> None:
    bridge = Bridge()
    page = Page(bridge.boards)
    page.connect()
    transport, recorder = bridge.served[0]
    await asyncio.sleep(1.0)
    transport.pause_reading()
    assert not page.is_read
    await asyncio.sleep(60.0)
    assert not recorder.losses
    transport.resume_reading()
    await asyncio.sleep(1.0)
    assert page.is_read
    page.transport.closed()
    assert isinstance(await recorder.until_lost(), PeerClosedError)


@on_virtual_time
async def test_a_page_that_connects_again_replaces_its_old_connection() -> None:
    bridge = Bridge(max_boards=2)
    first, other, again, third = (Page(bridge.boards) for _ in range(4))
    first.connect()
    other.connect(key="another-uno")
    again.connect()
    assert await bridge.served[0][1].until_lost() is None
    assert first.closed is not None
    assert not bridge.served[1][1].losses
    third.connect(key="a-third-uno")
    assert third.closed == (1013, "the limit of boards on pages (2) is reached; disconnect another board")
    await bridge.boards.close()
    await bridge.served[2][1].until_lost()
    late = Page(bridge.boards)
    late.connect()
    assert late.closed == (1013, "the bridge is not running; try again later")


@on_virtual_time
async def test_a_page_without_a_hello_is_refused() -> None:
    boards = Bridge().boards
    silent, hasty, wrong, false = (Page(boards) for _ in range(4))
    hasty.transport.received(b"\xff\xfe")
    assert hasty.closed == (1008, "the first message of a page must name its board, as text")
    wrong.connect(name="../uno")
    assert wrong.closed is not None
    false.connect()
    false.report(1)
    assert false.closed == (1008, "a page must report 0 to 0 written bytes, not 1")
    await asyncio.sleep(HELLO_LIMIT_S + 0.1)
    assert silent.closed == (1008, "the page did not name its board")


@pytest.mark.parametrize(
    ("text", "mistake"),
    [
        ("", "truncated"),
        ("[" * 900, "expected object"),
        ("x" * 2000, "at most 1000 characters"),
        ('{"op":"connect","name":"a b","key":"12345678","baud":9600}', "invalid: name: "),
        ('{"op":"connect","name":"a","key":"1","baud":9600}', "invalid: key: "),
        ('{"op":"connect","name":"a","key":"12345678","baud":true}', "expected integer, got boolean"),
        ('{"op":"connect","name":"a","key":"12345678","baud":0}', "expected integer >= 1"),
    ],
)
def test_a_wrong_hello_is_explained(text: str, mistake: str) -> None:
    with pytest.raises(RemoteProtocolError, match=mistake):
        read_hello(text)
