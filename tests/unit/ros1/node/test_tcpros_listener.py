"""The TCPROS port of a node, with peers that misbehave."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

from rostether.errors import ConfigError, GraphError
from rostether.ros1.graph_limits import GraphLimits
from rostether.ros1.node import tcpros_listener
from rostether.ros1.node.tcpros_listener import TcprosListener
from rostether.tcpros.header import MAX_HEADER_BYTES
from unit.ros1.node.raw_peers import RawPeer, until
from unit.transports.strangers import is_hung_up, stranger


def refuse_subscriber(fields: dict[str, str], _: asyncio.Transport) -> asyncio.Protocol:
    raise GraphError(f"[/node] is not a publisher of [{fields['topic']}]")


def refuse_client(fields: dict[str, str], _: asyncio.Transport) -> asyncio.Protocol:
    raise GraphError(f"[/node] is not a provider of [{fields['service']}]")


@pytest_asyncio.fixture
async def listener() -> AsyncIterator[TcprosListener]:
    listener = TcprosListener(refuse_subscriber, refuse_client, lambda *_: None)
    await listener.start(["127.0.0.1"])
    yield listener
    await listener.close()


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"topic": "/a", "md5sum": "*"}, "is not a publisher of [/a]"),
        ({"service": "/a", "md5sum": "*"}, "is not a provider of [/a]"),
        ({"callerid": "/a"}, "no topic or service name detected"),
        ({"topic": "/a"}, "Missing required 'md5sum' field"),
    ],
)
async def test_a_refusal_is_reported(listener: TcprosListener, fields: dict[str, str], reason: str) -> None:
    peer = await RawPeer.connect(listener.port)
    peer.send_header(fields)
    assert reason in (await peer.read_header())["error"]
    assert await peer.is_hung_up()
    await peer.close()


@pytest.mark.parametrize(
    "data", [b"GET / HTTP/1.1\r\n\r\n", struct.pack("<I", MAX_HEADER_BYTES + 1), b"\x05\0\0\0\x09\0\0\0x"]
)
async def test_garbage_is_refused(listener: TcprosListener, data: bytes) -> None:
    peer = await RawPeer.connect(listener.port)
    peer.writer.write(data)
    assert "header" in (await peer.read_header())["error"]
    assert await peer.is_hung_up()
    await peer.close()


async def test_a_silent_client_is_disconnected() -> None:
    listener = TcprosListener(
        refuse_subscriber, refuse_client, lambda *_: None, limits=GraphLimits(header_s=0.05)
    )
    await listener.start(["127.0.0.1"])
    peer = await RawPeer.connect(listener.port)
    peer.writer.write(b"\x10\0")
    assert await peer.is_hung_up()
    await peer.close()
    await listener.close()


async def test_many_silent_connections_do_not_block_others(
    listener: TcprosListener, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tcpros_listener, "MAX_HANDSHAKES", 3)
    crowd = [await RawPeer.connect(listener.port) for _ in range(5)]
    assert await crowd[0].is_hung_up()
    assert await crowd[1].is_hung_up()
    crowd[4].send_header({"callerid": "/a"})
    assert "error" in await crowd[4].read_header()
    for peer in crowd:
        await peer.close()
    await until(lambda: not listener._handshakes)


async def test_one_address_leaves_room_for_others(
    listener: TcprosListener, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tcpros_listener, "is_loopback", lambda host: host != "127.0.0.2")
    monkeypatch.setattr(tcpros_listener, "MAX_HANDSHAKES_PER_HOST", 1)
    friend = await RawPeer.connect(listener.port)
    async with stranger(listener.port) as (first, _):
        await until(lambda: len(listener._handshakes) == 2)
        async with stranger(listener.port):
            assert await is_hung_up(first)
            friend.send_header({"callerid": "/a"})
            assert "error" in await friend.read_header()
    await friend.close()


@pytest.mark.parametrize(
    ("limits", "reason"),
    [
        (GraphLimits(tcpros_connections=1), "the limit of connections to this node (1) is reached; close"),
        (
            GraphLimits(tcpros_connections_per_host=1),
            "the limit of connections from one address (1) is reached",
        ),
    ],
)
async def test_connections_that_stay_are_counted(
    limits: GraphLimits, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tcpros_listener, "is_loopback", lambda _host: False)
    listener = TcprosListener(lambda *_: asyncio.Protocol(), refuse_client, lambda *_: None, limits=limits)
    await listener.start(["127.0.0.1"])
    fields = {"topic": "/a", "md5sum": "*"}
    first, second = await RawPeer.connect(listener.port), await RawPeer.connect(listener.port)
    first.send_header(fields)
    await until(lambda: len(listener._served) == 1)
    second.send_header(fields)
    assert reason in (await second.read_header())["error"]
    await first.close()
    await until(lambda: all(each.is_closing() for each in listener._served))
    third = await RawPeer.connect(listener.port)
    third.send_header(fields)
    await until(lambda: any(not each.is_closing() for each in listener._served))
    for peer in (second, third):
        await peer.close()
    await listener.close()


async def test_closing_ends_connections_and_frees_the_port(listener: TcprosListener) -> None:
    port = listener.port
    peer = await RawPeer.connect(port)
    await until(lambda: listener._handshakes)
    await listener.close()
    await listener.close()
    assert await peer.is_hung_up()
    await peer.close()
    with pytest.raises(ConnectionError):
        await RawPeer.connect(port)


async def test_an_address_of_another_machine_is_named() -> None:
    listener = TcprosListener(refuse_subscriber, refuse_client, lambda *_: None)
    with pytest.raises(ConfigError, match=r"cannot listen on 192.0.2.1.*ROS_IP"):
        await listener.start(["192.0.2.1"])


async def test_several_addresses_share_one_port() -> None:
    listener = TcprosListener(refuse_subscriber, refuse_client, lambda *_: None)
    await listener.start(["127.0.0.1", "127.0.0.2"])
    _, writer = await asyncio.open_connection("127.0.0.2", listener.port)
    writer.close()
    await writer.wait_closed()
    await listener.close()


async def test_many_large_headers_cannot_fill_the_memory(
    listener: TcprosListener, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tcpros_listener, "MAX_HEADERS_BYTES", 300_000)
    begun = struct.pack("<I", MAX_HEADER_BYTES) + bytes(200_000)
    first, second = await RawPeer.connect(listener.port), await RawPeer.connect(listener.port)
    first.writer.write(begun)
    await until(lambda: sum(each.held_bytes for each in listener._handshakes) == len(begun))
    second.writer.write(begun)
    assert await second.is_hung_up()
    assert sum(each.held_bytes for each in listener._handshakes) == len(begun), "the first goes on"
    await first.close()
    await second.close()
