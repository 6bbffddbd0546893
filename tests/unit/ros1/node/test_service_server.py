"""A service, called with raw sockets."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

from contract.graphs import SET_BOOL
from rostether.errors import SessionError
from rostether.ros1.node.service_server import ServiceServer
from rostether.ros1.node.tcpros_listener import TcprosListener
from rostether.tcpros.handshake import client_fields, probe_fields
from rostether.tcpros.message_framing import encode_messages
from unit.ros1.node.raw_peers import RawPeer, until


class Stage:
    """One service behind a listener."""

    def __init__(self) -> None:
        self.handled: list[bytes] = []
        self.go_on = asyncio.Event()
        self.go_on.set()
        self.server = ServiceServer(
            "/switch", SET_BOOL, self.handle, node_name="/server", on_close=self._release
        )
        self.listener = TcprosListener(self.server.accept, self.server.accept, lambda *_: None)

    async def handle(self, request: bytes) -> bytes:
        await self.go_on.wait()
        self.handled.append(request)
        if request == b"refuse":
            raise SessionError("the board did not answer")
        if request == b"fail":
            raise ZeroDivisionError("a mistake")
        return request + b"!"

    async def _release(self, _: ServiceServer) -> None:
        pass

    async def call(self, **fields: str) -> RawPeer:
        peer = await RawPeer.connect(self.listener.port)
        peer.send_header(client_fields("/switch", SET_BOOL, caller_id="/raw", persistent=False) | fields)
        return peer


@pytest_asyncio.fixture
async def stage() -> AsyncIterator[Stage]:
    stage = Stage()
    await stage.listener.start(["127.0.0.1"])
    yield stage
    await stage.server.close()
    await stage.listener.close()


@pytest.mark.parametrize("md5sum", [SET_BOOL.md5sum, "*"])
async def test_a_single_call_is_answered_and_disconnected(stage: Stage, md5sum: str) -> None:
    peer = await stage.call(md5sum=md5sum)
    assert await peer.read_header() == {
        "callerid": "/server",
        "md5sum": SET_BOOL.md5sum,
        "request_type": "std_srvs/SetBoolRequest",
        "response_type": "std_srvs/SetBoolResponse",
        "service": "/switch",
        "type": "std_srvs/SetBool",
    }
    peer.writer.write(encode_messages([b"on", b"ignored"]))
    assert await peer.read_answer() == (1, b"on!")
    assert await peer.is_hung_up()
    assert stage.handled == [b"on"]
    await peer.close()


async def test_a_persistent_connection_serves_many_calls(stage: Stage) -> None:
    peer = await stage.call(persistent="1")
    await peer.read_header()
    for number in range(3):
        peer.writer.write(encode_messages([b"%d" % number]))
        assert await peer.read_answer() == (1, b"%d!" % number)
    # Several at once are answered in order, an error does not end the connection.
    peer.writer.write(encode_messages([b"a", b"refuse", b"fail", b"b"]))
    assert await peer.read_answer() == (1, b"a!")
    assert await peer.read_answer() == (0, b"the board did not answer")
    assert await peer.read_answer() == (0, b"error processing request: a mistake")
    assert await peer.read_answer() == (1, b"b!")
    await peer.close()
    await until(lambda: not stage.server._connections)


async def test_many_requests_of_one_read_leave_turns_to_other_tasks(stage: Stage) -> None:
    peer = await stage.call(persistent="1")
    await peer.read_header()
    peer.writer.write(encode_messages([b""] * 1000))
    turns = 0
    while len(stage.handled) < 1000:
        await asyncio.sleep(0)
        turns += 1
    assert turns >= 1000
    await peer.close()


async def test_a_probe_is_answered_and_disconnected(stage: Stage) -> None:
    peer = await RawPeer.connect(stage.listener.port)
    peer.send_header(probe_fields("/switch", caller_id="/raw"))
    assert (await peer.read_header())["type"] == "std_srvs/SetBool"
    assert await peer.is_hung_up()
    assert stage.handled == []
    await peer.close()


async def test_another_type_is_refused(stage: Stage) -> None:
    peer = await stage.call(md5sum="1" * 32)
    assert "md5sums do not match" in (await peer.read_header())["error"]
    assert await peer.is_hung_up()
    await peer.close()


async def test_a_client_that_closes_its_sending_side_gets_its_answer(stage: Stage) -> None:
    stage.go_on.clear()
    peer = await stage.call()
    await peer.read_header()
    peer.writer.write(encode_messages([b"on"]))
    peer.writer.write_eof()
    await until(lambda: any(each._task for each in stage.server._connections))
    stage.go_on.set()
    assert await peer.read_answer() == (1, b"on!")
    assert await peer.is_hung_up()
    await peer.close()


async def test_a_client_that_disconnects_does_not_stop_its_handler(stage: Stage) -> None:
    stage.go_on.clear()
    peer = await stage.call()
    await peer.read_header()
    peer.writer.write(encode_messages([b"on"]))
    await until(lambda: any(each._task for each in stage.server._connections))
    peer.writer.transport.abort()
    stage.go_on.set()
    await until(lambda: stage.handled == [b"on"] and not stage.server._connections)


async def test_a_request_above_the_limit_is_answered_with_the_limit(stage: Stage) -> None:
    peer = await stage.call()
    await peer.read_header()
    peer.writer.write(struct.pack("<I", 0xFFFFFFFF))
    ok, text = await peer.read_answer()
    assert not ok
    assert b"bytes, more than" in text
    assert await peer.is_hung_up()
    await peer.close()


async def test_closing_informs_a_waiting_client(stage: Stage) -> None:
    stage.go_on.clear()
    idle, busy = await stage.call(persistent="1"), await stage.call()
    for peer in (idle, busy):
        await peer.read_header()
    busy.writer.write(encode_messages([b"on"]))
    await until(lambda: any(each._task for each in stage.server._connections))
    await stage.server.close()
    assert await busy.read_answer() == (0, b"the service has been shut down")
    for peer in (idle, busy):
        assert await peer.is_hung_up()
        await peer.close()
    assert stage.handled == []
