"""A service client and servers that misbehave."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable

import pytest
import pytest_asyncio

from contract.graphs import EMPTY, SET_BOOL
from rostether.errors import (
    ServiceCallError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    TypeMismatchError,
)
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node import service_client
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.service_client import ServiceClient
from rostether.tcpros.handshake import server_fields
from rostether.tcpros.service_framing import encode_error, encode_response
from rostether.transports.sockets import close_servers
from unit.ros1.node.raw_peers import RawPeer
from waiting import until


class FakeServer:
    """A provider of /switch; `serve` is its side of each connection."""

    def __init__(self) -> None:
        self.connections = 0
        self.headers: list[dict[str, str]] = []
        self.serve: Callable[[RawPeer], Awaitable[None]] = self.answer_all
        self.fields = server_fields("/switch", SET_BOOL, caller_id="/fake")

    async def start(self, master: MasterClient) -> None:
        self._server = await asyncio.start_server(self._take, "127.0.0.1", 0)
        port = self._server.sockets[0].getsockname()[1]
        await master.register_service("/switch", f"rosrpc://127.0.0.1:{port}", "http://127.0.0.1:1/")

    async def close(self) -> None:
        await close_servers([self._server])
        await self._server.wait_closed()

    async def answer_all(self, peer: RawPeer) -> None:
        while True:
            peer.writer.write(encode_response(await peer.read_message() + b"!"))

    async def _take(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.connections += 1
        peer = RawPeer(reader, writer)
        try:
            self.headers.append(await peer.read_header())
            peer.send_header(self.fields)
            await self.serve(peer)
        except (asyncio.IncompleteReadError, ConnectionError):
            pass
        finally:
            await peer.close()


class Stage:
    def __init__(self, master: MasterServer) -> None:
        self.master = MasterClient(master.uri, "/client")
        self.server = FakeServer()

    def client(self, *, persistent: bool = False) -> ServiceClient:
        return ServiceClient("/switch", SET_BOOL, self.master, persistent=persistent)


@pytest_asyncio.fixture
async def stage() -> AsyncIterator[Stage]:
    master = await MasterServer.start(port=0)
    stage = Stage(master)
    await stage.server.start(stage.master)
    yield stage
    await stage.server.close()
    await stage.master.close()
    await master.close()


async def test_a_call_connects_again_each_time(stage: Stage) -> None:
    client = stage.client()
    assert await client.call(b"on") == b"on!"
    assert await client.call(b"off", timeout_s=60) == b"off!"
    assert stage.server.connections == 2
    assert "persistent" not in stage.server.headers[0]
    assert stage.server.headers[0] == {
        "callerid": "/client",
        "md5sum": SET_BOOL.md5sum,
        "service": "/switch",
        "type": "std_srvs/SetBool",
    }


async def test_a_persistent_client_keeps_its_connection(stage: Stage) -> None:
    client = stage.client(persistent=True)
    answers = await asyncio.gather(*(client.call(b"%d" % number) for number in range(5)))
    assert answers == [b"0!", b"1!", b"2!", b"3!", b"4!"]
    assert stage.server.connections == 1
    assert stage.server.headers[0]["persistent"] == "1"
    await client.close()
    await client.close()


async def test_a_persistent_client_connects_again_after_its_connection_ends(stage: Stage) -> None:
    async def answer_one(peer: RawPeer) -> None:
        peer.writer.write(encode_response(await peer.read_message()))

    stage.server.serve = answer_one
    client = stage.client(persistent=True)
    for _ in range(3):
        assert await client.call(b"on") == b"on"
        kept = client._kept
        assert kept is not None
        await until(lambda: not kept.is_open)  # noqa: B023 - awaited at once
    assert stage.server.connections == 3


async def test_a_connection_that_ends_during_the_call_is_an_error(stage: Stage) -> None:
    async def hang_up(peer: RawPeer) -> None:
        await peer.read_message()

    stage.server.serve = hang_up
    for persistent in (False, True):
        client = stage.client(persistent=persistent)
        with pytest.raises(
            ServiceCallError, match="/switch: the server closed the connection during the call"
        ):
            await client.call(b"on")
        assert client._kept is None


async def test_a_late_answer_is_never_used_for_another_call(stage: Stage) -> None:
    go_on = asyncio.Event()

    async def answer_late(peer: RawPeer) -> None:
        request = await peer.read_message()
        if request == b"slow":
            await go_on.wait()
        peer.writer.write(encode_response(request))
        await peer.read_message()

    stage.server.serve = answer_late
    client = stage.client(persistent=True)
    with pytest.raises(ServiceTimeoutError, match=r"/switch did not answer within 0.05 s"):
        await client.call(b"slow", timeout_s=0.05)
    go_on.set()
    assert await client.call(b"quick", timeout_s=60) == b"quick"
    await client.close()


async def test_an_error_has_the_text_of_the_server(stage: Stage) -> None:
    async def refuse(peer: RawPeer) -> None:
        await peer.read_message()
        peer.writer.write(encode_error("motor too hot"))
        await peer.read_message()

    stage.server.serve = refuse
    with pytest.raises(ServiceCallError, match="/switch responded with an error: motor too hot"):
        await stage.client().call(b"on")


@pytest.mark.parametrize("answer", [b"\x01\xff\xff\xff\xff", encode_response(b"1") + encode_response(b"2")])
async def test_malformed_answers_are_errors(stage: Stage, answer: bytes) -> None:
    async def confuse(peer: RawPeer) -> None:
        await peer.read_message()
        peer.writer.write(answer)
        await peer.read_message()

    stage.server.serve = confuse
    with pytest.raises(ServiceCallError):
        await stage.client().call(b"on")


async def test_a_server_of_another_type_is_named(stage: Stage) -> None:
    stage.server.fields = server_fields("/switch", EMPTY, caller_id="/fake")
    with pytest.raises(TypeMismatchError, match="service /switch has type std_srvs/Empty"):
        await stage.client().call(b"on")
    stage.server.fields = {"error": "request from [/client]: md5sums do not match: [1] vs. [2]"}
    with pytest.raises(TypeMismatchError, match=r"another type .* than std_srvs/SetBool .*md5sums do not"):
        await stage.client().call(b"on")


async def test_a_server_that_refuses_or_has_ended_is_unavailable(stage: Stage) -> None:
    stage.server.fields = {"error": "[/fake] is not a provider of [/switch]"}
    with pytest.raises(ServiceUnavailableError, match="is not a provider"):
        await stage.client().call(b"on")
    await stage.server.close()
    with pytest.raises(ServiceUnavailableError, match=r"registered at rosrpc://.* cannot be called"):
        await stage.client().call(b"on")
    await stage.master.register_service("/switch", "http://nonsense", "http://127.0.0.1:1/")
    with pytest.raises(ServiceUnavailableError, match="is not a URI"):
        await stage.client().call(b"on")


async def test_waiting_ends_when_a_server_answers(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service_client, "POLL_INTERVAL_S", 0.01)
    client = ServiceClient("/later", SET_BOOL, stage.master)
    with pytest.raises(ServiceUnavailableError, match="no node offers the service /later"):
        await client.wait_until_available(0.05)
    waiting = asyncio.ensure_future(client.wait_until_available())
    uri = await stage.master.lookup_service("/switch")
    await stage.master.register_service("/later", uri, "http://127.0.0.1:1/")
    await asyncio.wait_for(waiting, 60)
    assert stage.server.headers[-1]["probe"] == "1"
