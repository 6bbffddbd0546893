"""The XML-RPC client, against our server and against peers that misbehave."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable

import pytest

from rostether.errors import ConfigError, GraphError, MasterUnreachableError, SerializationError
from rostether.mechanisms.block_end import closed_at_end
from rostether.ros1.xmlrpc_client import MAX_IDLE_CONNECTIONS, XmlRpcClient
from rostether.ros1.xmlrpc_server import XmlRpcServer
from rostether.transports.sockets import close_servers
from rostether.xmlrpc.document_writer import dump_response
from rostether.xmlrpc.http_message import HttpServerSide

Session = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


def http_answer(value: object) -> bytes:
    body = dump_response(value)
    return b"HTTP/1.1 200 OK\r\nContent-Length: %d\r\n\r\n" % len(body) + body


@contextlib.asynccontextmanager
async def peer(session: Session) -> AsyncIterator[str]:
    """Serve each connection with `session`; yields the URI."""
    tasks: set[asyncio.Task[None]] = set()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        tasks.add(task)
        try:
            await session(reader, writer)
        finally:
            writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    try:
        yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/"
    finally:
        await close_servers([server])
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await server.wait_closed()


async def read_request(reader: asyncio.StreamReader) -> None:
    http = HttpServerSide()
    while http.next_request() is None:
        data = await reader.read(65536)
        if not data:
            raise EOFError
        http.receive_data(data)


@pytest.fixture
async def server() -> AsyncIterator[XmlRpcServer]:
    server = XmlRpcServer({"echo": lambda *args: list(args), "triplet": lambda *args: [1, "ok", list(args)]})
    await server.start()
    yield server
    await server.close()


async def test_calls_one_after_the_other_share_a_connection(server: XmlRpcServer) -> None:
    client = XmlRpcClient(server.uri)
    for number in range(5):
        assert await client.call("echo", number) == [number]
    assert len(server._connections) == 1
    await client.close()


async def test_kept_connections_are_few(server: XmlRpcServer) -> None:
    client = XmlRpcClient(server.uri)
    count = MAX_IDLE_CONNECTIONS + 3
    assert await asyncio.gather(*(client.call("echo", n) for n in range(count))) == [
        [n] for n in range(count)
    ]
    async with asyncio.timeout(60):
        while len(server._connections) > MAX_IDLE_CONNECTIONS:
            await asyncio.sleep(0.001)
    assert len(client._idle) == MAX_IDLE_CONNECTIONS
    await client.close()


async def test_localhost_is_reached_without_ipv6(server: XmlRpcServer) -> None:
    client = XmlRpcClient(f"http://localhost:{server.port}")
    assert await client.call("echo") == []
    await client.close()


async def test_status_triplets(server: XmlRpcServer) -> None:
    client = XmlRpcClient(server.uri)
    assert await client.call_status("triplet", "x") == (1, "ok", ["x"])
    with pytest.raises(GraphError, match=r"answered echo without \[code, message, value\]"):
        await client.call_status("echo")
    await client.close()


async def test_a_restarted_server_is_reached_again() -> None:
    first = XmlRpcServer({"who": lambda: 1})
    await first.start()
    client = XmlRpcClient(first.uri)
    assert await client.call("who") == 1
    await first.close()
    second = XmlRpcServer({"who": lambda: 2}, port=first.port)
    await second.start()
    assert await client.call("who") == 2
    await client.close()
    await second.close()


async def test_a_request_on_a_connection_that_closes_is_repeated_once() -> None:
    count = 0

    async def session(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonlocal count
        count += 1
        await read_request(reader)
        writer.write(http_answer(count))
        # The second request on this connection is dropped, as by a server that closes idle connections.
        with contextlib.suppress(EOFError):
            await read_request(reader)

    async with peer(session) as uri:
        client = XmlRpcClient(uri)
        assert await client.call("x") == 1
        assert await client.call("x") == 2
        await client.close()
    assert count == 2


async def test_a_request_on_a_new_connection_that_breaks_is_not_repeated() -> None:
    count = 0

    async def session(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonlocal count
        count += 1
        await read_request(reader)

    async with peer(session) as uri:
        client = XmlRpcClient(uri)
        with pytest.raises(GraphError, match=r"sent an invalid answer to x|cannot be reached"):
            await client.call("x")
    assert count == 1


async def test_a_request_is_not_repeated_after_half_an_answer() -> None:
    count = 0

    async def session(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonlocal count
        await read_request(reader)
        writer.write(http_answer(1))
        await read_request(reader)
        count += 1
        writer.write(http_answer(1)[:-5])

    async with peer(session) as uri:
        client = XmlRpcClient(uri)
        await client.call("x")
        with pytest.raises(GraphError):
            await client.call("x")
        await client.close()
    assert count == 1


async def test_on_lost_is_called_when_the_server_ends() -> None:
    server = XmlRpcServer({"ping": lambda: 1})
    await server.start()
    lost = asyncio.Event()
    client = XmlRpcClient(server.uri, on_lost=lost.set)
    await client.call("ping")
    assert not lost.is_set()
    await server.close()
    await asyncio.wait_for(lost.wait(), 60)
    await client.close()


async def test_on_lost_is_not_called_when_we_disconnect(server: XmlRpcServer) -> None:
    lost: list[int] = []
    client = XmlRpcClient(server.uri, on_lost=lambda: lost.append(1))
    await client.call("echo")
    client.disconnect()
    async with asyncio.timeout(60):
        while server._connections:
            await asyncio.sleep(0.001)
    assert await client.call("echo") == [], "a client can call again after it disconnects"
    await client.close()
    assert lost == []


async def test_no_peer() -> None:
    server = XmlRpcServer({})
    await server.start()
    await server.close()
    client = XmlRpcClient(server.uri, peer="the ROS master", unreachable=MasterUnreachableError)
    with pytest.raises(MasterUnreachableError) as raised:
        await client.call("getPid", "/x")
    assert f"the ROS master at {server.uri} cannot be reached (Connection refused)" in str(raised.value)
    assert isinstance(raised.value.__cause__, ConnectionRefusedError)


async def test_silence() -> None:
    async def session(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await asyncio.Event().wait()

    async with peer(session) as uri:
        client = XmlRpcClient(uri, unreachable=MasterUnreachableError, timeout_s=0.05)
        with pytest.raises(MasterUnreachableError, match=r"did not answer getPid in 0\.05 s"):
            await client.call("getPid")


async def test_a_name_that_cannot_be_resolved() -> None:
    client = XmlRpcClient(f"http://{'x' * 70}.invalid:1/")
    with pytest.raises(GraphError, match="cannot be reached"):
        await client.call("x")


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (b"SSH-2.0-OpenSSH_9.2\r\n\r\n", "sent an invalid answer to .*: the answer is not HTTP"),
        (
            b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n",
            "is not a node: it answered x with HTTP status 404$",
        ),
        (
            b"HTTP/1.1 501 Unsupported\r\nContent-Length: 22\r\n\r\n<!DOCTYPE HTML>\n<html>",
            "is not a node: it answered x with HTTP status 501$",
        ),
        (b"HTTP/1.1 403 Forbidden\r\nContent-Length: 7\r\n\r\ngo away", "HTTP status 403: go away$"),
        (
            b"HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\nhello",
            "sent an invalid answer to .*: the XML-RPC document",
        ),
    ],
)
async def test_another_program_at_the_address(answer: bytes, reason: str) -> None:
    async def session(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await read_request(reader)
        writer.write(answer)

    async with peer(session) as uri:
        client = XmlRpcClient(uri)
        with pytest.raises(GraphError, match=reason) as raised:
            await client.call("x")
        assert "\n" not in str(raised.value)
        await client.close()


async def test_an_unrequested_answer_ends_the_connection() -> None:
    async def session(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await read_request(reader)
        writer.write(http_answer(1))
        await writer.drain()
        writer.write(http_answer(2))
        with contextlib.suppress(EOFError):
            await read_request(reader)

    lost = asyncio.Event()
    async with peer(session) as uri:
        client = XmlRpcClient(uri, on_lost=lost.set)
        assert await client.call("x") == 1
        # The second answer came either with the first, or while the connection was kept.
        if client._idle:
            await asyncio.wait_for(lost.wait(), 60)
        assert not client._idle
        await client.close()


async def test_a_cancelled_call_closes_its_connection(server: XmlRpcServer) -> None:
    async def session(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await read_request(reader)
        began.set()
        assert await reader.read() == b""
        ended.set()

    began, ended = asyncio.Event(), asyncio.Event()
    async with peer(session) as uri:
        client = XmlRpcClient(uri)
        task = asyncio.create_task(client.call("x"))
        await asyncio.wait_for(began.wait(), 60)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        await asyncio.wait_for(ended.wait(), 60)


async def test_a_running_call_survives_close(server: XmlRpcServer) -> None:
    client = XmlRpcClient(server.uri)
    task = asyncio.create_task(client.call("echo", 1))
    await asyncio.sleep(0)
    await client.close()
    assert await task == [1]
    async with asyncio.timeout(60):
        while server._connections:
            await asyncio.sleep(0.001)


async def test_a_value_that_cannot_be_sent_is_not_sent(server: XmlRpcServer) -> None:
    client = XmlRpcClient(server.uri)
    with pytest.raises(SerializationError, match="32 bits"):
        await client.call("echo", 2**40)
    assert not server._connections


def test_a_bad_uri_is_refused_at_once() -> None:
    with pytest.raises(ConfigError, match="not a URI"):
        XmlRpcClient("localhost:11311")


async def test_what_to_do_about_somebody_else_there() -> None:
    async def session(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await read_request(reader)
        writer.write(b"HTTP/1.1 501 Unsupported\r\nContent-Length: 0\r\n\r\n")

    async with peer(session) as uri:
        client = XmlRpcClient(
            uri, peer="the ROS master", other_server_advice="; check which program listens there"
        )
        with pytest.raises(
            GraphError, match=r"is not a ROS master: .* status 501; check which program listens there$"
        ):
            await client.call("x")
        await client.close()


async def test_the_host_header_has_ipv6_addresses_in_brackets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.ros1.xmlrpc_client.connect_host", lambda _host: "127.0.0.1")
    heads: list[bytes] = []

    async def session(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        heads.append(await reader.readuntil(b"\r\n\r\n"))
        writer.write(http_answer(1))

    async with peer(session) as uri, closed_at_end(XmlRpcClient(uri.replace("127.0.0.1", "[::1]"))) as client:
        assert await client.call("ask") == 1
        port = uri.rpartition(":")[2].rstrip("/")
        assert f"host: [::1]:{port}\r\n".encode() in heads[0].lower()
