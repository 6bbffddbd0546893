"""HTTP requests to the gateways' sockets: in single bytes, many at once, endless."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator

import pytest
from websockets.asyncio.client import connect
from websockets.typing import Subprotocol

from loop_watch import CallbackWatch
from unit.gateways.foxglove.protocol_client import stage
from unit.gateways.rosbridge.web_client import world

TIMEOUT_S = 60.0
GATEWAYS = ["foxglove", "rosbridge"]
SUBPROTOCOLS = [Subprotocol("foxglove.websocket.v1")]
PIPELINED = 20_000
# What a server may store of a request's head and of the data after it.
MAX_HEAD_BYTES = 2 * 1024 * 1024


@contextlib.asynccontextmanager
async def open_gateway(gateway: str) -> AsyncIterator[int]:
    """Serve a gateway; yield its port."""
    if gateway == "foxglove":
        async with stage() as foxglove:
            yield foxglove.gateway.port
    else:
        async with world() as rosbridge:
            yield rosbridge.server.port


def upgrade(port: int) -> bytes:
    return (
        f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
        f"Sec-WebSocket-Protocol: {SUBPROTOCOLS[0]}\r\n\r\n"
    ).encode()


async def connect_another_client(gateway: str, port: int) -> None:
    """Connect and disconnect a client; fail if the gateway does not accept it in time."""
    protocols = SUBPROTOCOLS if gateway == "foxglove" else None
    async with asyncio.timeout(TIMEOUT_S), connect(f"ws://127.0.0.1:{port}", subprotocols=protocols):
        pass


async def send_until_refused(writer: asyncio.StreamWriter, data: bytes) -> None:
    """Send in pieces; stop when the server has ended the connection."""
    with contextlib.suppress(OSError):
        for start in range(0, len(data), 65536):
            writer.write(data[start : start + 65536])
            await writer.drain()


@pytest.mark.parametrize("gateway", GATEWAYS)
async def test_an_upgrade_in_single_bytes_is_accepted(gateway: str, monkeypatch: pytest.MonkeyPatch) -> None:
    async with open_gateway(gateway) as port:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, True)
        watch = CallbackWatch(monkeypatch)
        for byte in upgrade(port):
            writer.write(bytes([byte]))
            # The event loop runs in between, so that the gateway reads single bytes.
            await asyncio.sleep(0)
        async with asyncio.timeout(TIMEOUT_S):
            assert b" 101 " in await reader.readline()
        watch.check("an upgrade in single bytes")
        writer.close()


@pytest.mark.parametrize("gateway", GATEWAYS)
@pytest.mark.parametrize("kind", ["GET", "upgrade"])
async def test_pipelined_requests_do_not_delay_others(
    gateway: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_gateway(gateway) as port:
        request = (
            upgrade(port)
            if kind == "upgrade"
            else f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode()
        )
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        watch = CallbackWatch(monkeypatch)
        sending = asyncio.create_task(send_until_refused(writer, request * PIPELINED))
        await connect_another_client(gateway, port)
        async with asyncio.timeout(TIMEOUT_S):
            answer = b""
            with contextlib.suppress(OSError):
                while data := await reader.read(65536):
                    answer += data
            await sending
        watch.check(f"{PIPELINED} pipelined requests")
        assert answer.count(b"HTTP/1.1 ") <= 1, "more than the first request was answered"
        writer.close()


@pytest.mark.parametrize("gateway", GATEWAYS)
async def test_two_upgrades_at_once_cause_no_internal_error(
    gateway: str, caplog: pytest.LogCaptureFixture
) -> None:
    async with open_gateway(gateway) as port:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        # In one chunk, so that the second is read as a frame before the first is answered.
        writer.write(upgrade(port) * 2)
        async with asyncio.timeout(TIMEOUT_S):
            assert (await reader.read()).count(b"HTTP/1.1 ") == 1
    # Closing the gateway while the client was connected logged no error.
    writer.close()
    assert "Fatal error" not in caplog.text


@pytest.mark.parametrize("gateway", GATEWAYS)
@pytest.mark.parametrize("line", [b"a", b"a: b\r\n", b"\r\n"])
async def test_a_head_without_an_end_is_refused(
    gateway: str, line: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_gateway(gateway) as port:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        watch = CallbackWatch(monkeypatch)
        writer.write(b"GET / HTTP/1.1\r\n" if line != b"\r\n" else b"")
        sending = asyncio.create_task(send_until_refused(writer, line * (16 * MAX_HEAD_BYTES // len(line))))
        await connect_another_client(gateway, port)
        async with asyncio.timeout(TIMEOUT_S):
            with contextlib.suppress(OSError):
                while await reader.read(65536):
                    pass
            await sending
        watch.check("a head without an end")
        writer.close()
