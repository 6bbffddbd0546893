"""One connection, byte by byte, with data that a WebSocket library would not send."""

from __future__ import annotations

import asyncio
import os
import socket
import ssl
import struct
import subprocess
from pathlib import Path
from typing import TypeAlias, cast

import pytest
from msgspec.structs import replace
from websockets.asyncio.client import connect
from websockets.typing import Subprotocol

from loop_watch import MAX_HELD_S
from rostether.gateways.foxglove.settings import FoxgloveLimits, FoxgloveSettings
from rostether.gateways.websocket import connection as connection_module
from tls_handshakes import handshakes_in_memory
from unit.gateways.foxglove.protocol_client import TIMEOUT_S, stage
from waiting import until

Connection: TypeAlias = tuple[asyncio.StreamReader, asyncio.StreamWriter]

UPGRADE = (
    b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
    b"Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
)


def frame(opcode: int, data: bytes, *, fin: bool = True) -> bytes:
    """A client's frame; a mask of zeros leaves the data as it is."""
    first = (0x80 if fin else 0) | opcode
    if len(data) < 126:
        return bytes((first, 0x80 | len(data))) + bytes(4) + data
    return bytes((first, 0x80 | 127)) + struct.pack(">Q", len(data)) + bytes(4) + data


async def open_connection(
    port: int, first: bytes = UPGRADE, *, host: str = "127.0.0.1"
) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    reader, writer = await asyncio.open_connection("127.0.0.1", port, local_addr=(host, 0))
    writer.write(first)
    return reader, writer


async def shaken(port: int) -> Connection:
    reader, writer = await open_connection(port)
    answer = await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), TIMEOUT_S)
    assert answer.startswith(b"HTTP/1.1 101")
    assert b"foxglove.sdk.v1" in answer
    return reader, writer


async def ended(reader: asyncio.StreamReader) -> bytes:
    """Return the remaining data until the end of the connection."""
    data = bytearray()
    try:
        async with asyncio.timeout(TIMEOUT_S):
            while chunk := await reader.read(65536):
                data += chunk
    except ConnectionError:
        pass
    return bytes(data)


@pytest.mark.parametrize(
    "noise", [b"\x16\x03\x01\x02\x00", b"GET / HTTP/1.1\r\n\r\n", b"\xff" * 20_000, b"POST /\r\n\r\n"]
)
async def test_what_is_not_a_websocket_is_disconnected(noise: bytes) -> None:
    settings = FoxgloveSettings(port=0, limits=FoxgloveLimits(handshake_s=0.2))
    async with stage(settings) as there:
        reader, writer = await open_connection(there.gateway.port, noise)
        answer = await ended(reader)
        assert b"101" not in answer
        writer.close()
        async with there.client() as client:
            await client.wait("serverInfo")


async def test_a_silent_client_is_disconnected() -> None:
    settings = FoxgloveSettings(port=0, limits=FoxgloveLimits(handshake_s=0.05))
    async with stage(settings) as there:
        reader, writer = await open_connection(there.gateway.port, b"")
        assert await ended(reader) == b""
        writer.close()


@pytest.mark.parametrize("is_encrypted", [False, True])
async def test_silent_connections_displace_each_other_and_no_client(
    tmp_path: Path, is_encrypted: bool
) -> None:
    certificate, key = _certificate(tmp_path) if is_encrypted else ("", "")
    limits = FoxgloveLimits(clients=2, others=1, handshake_s=3600.0)
    settings = FoxgloveSettings(port=0, limits=limits, certificate=certificate, key=key)
    trust = ssl.create_default_context(cafile=certificate) if is_encrypted else None
    async with stage(settings) as there:
        port = there.gateway.port
        url = f"{'wss' if is_encrypted else 'ws'}://localhost:{port}"

        def viewer() -> connect:
            protocols = [Subprotocol("foxglove.sdk.v1")]
            return connect(url, ssl=trust, subprotocols=protocols, proxy=None, open_timeout=TIMEOUT_S)

        async with viewer() as first:
            silent = [await open_connection(port, b"") for _ in range(5)]
            assert await ended(silent[0][0]) == b"", "before its TLS handshake, too"
            async with viewer() as second:
                for each in (first, second):
                    assert await asyncio.wait_for(each.recv(), TIMEOUT_S)
        for _, writer in silent:
            writer.close()


async def test_one_other_address_cannot_keep_clients_out() -> None:
    limits = FoxgloveLimits(clients=4, others=2, handshake_s=3600.0)
    async with stage(FoxgloveSettings(port=0, limits=limits)) as there:
        port = there.gateway.port
        opened = [await open_connection(port, host="127.0.0.2") for _ in range(3)]
        answers = [await asyncio.wait_for(each.readuntil(b"\r\n"), TIMEOUT_S) for each, _ in opened]
        assert sorted(answers)[:2] == [b"HTTP/1.1 101 Switching Protocols\r\n"] * 2
        assert b"503" in max(answers)
        assert "from one address (2) is reached" in there.reported[-1]
        slow = await open_connection(port, UPGRADE[:20])
        opened += [await open_connection(port, b"", host="127.0.0.2") for _ in range(8)]
        assert await ended(opened[3][0]) == b"", "the connections of that address replace each other"
        slow[1].write(UPGRADE[20:])
        assert b"101" in await asyncio.wait_for(slow[0].readuntil(b"\r\n"), TIMEOUT_S)
        for _, writer in (*opened, slow):
            writer.close()


async def test_encrypted_clients_are_served_at_once(tmp_path: Path) -> None:
    certificate, key = _certificate(tmp_path)
    async with stage(FoxgloveSettings(port=0, certificate=certificate, key=key)) as there:
        trust = ssl.create_default_context(cafile=certificate)

        async def connected() -> bytes:
            reader, writer = await asyncio.open_connection(
                "127.0.0.1", there.gateway.port, ssl=trust, server_hostname="localhost"
            )
            writer.write(UPGRADE)
            answer = await asyncio.wait_for(reader.readuntil(b"\r\n"), TIMEOUT_S)
            writer.close()
            return answer

        answers = await asyncio.gather(*(connected() for _ in range(20)))
        assert {each.split()[1] for each in answers} == {b"101"}


async def test_plain_http_on_an_encrypted_port_gets_the_hint_to_use_https(tmp_path: Path) -> None:
    certificate, key = _certificate(tmp_path)
    async with stage(FoxgloveSettings(port=0, certificate=certificate, key=key)) as there:
        reader, writer = await open_connection(
            there.gateway.port, b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"
        )
        answer = await ended(reader)
        assert answer.startswith(b"HTTP/1.1 400 Bad Request\r\n")
        assert b"use https:// instead" in answer
        writer.close()
        reader, writer = await open_connection(there.gateway.port, b"noise" * 100)
        assert b"HTTP" not in await ended(reader)
        writer.close()


async def test_displaced_and_failed_tls_handshakes_leave_nothing_in_memory(tmp_path: Path) -> None:
    certificate, key = _certificate(tmp_path)
    limits = FoxgloveLimits(clients=2, others=1, handshake_s=3600.0)
    settings = FoxgloveSettings(port=0, limits=limits, certificate=certificate, key=key)
    async with stage(settings) as there, handshakes_in_memory() as count:
        # The server accepts them in one turn, so most are displaced before their handshake starts.
        halves = await asyncio.gather(
            *(open_connection(there.gateway.port, b"\x16\x03\x01\x02\x00") for _ in range(40))
        )
        assert await ended(halves[0][0]) == b""
        await until(lambda: count() <= limits.clients + limits.others)
        for _, writer in halves:
            writer.close()
        noise = await open_connection(there.gateway.port, b"noise" * 100)
        await ended(noise[0])
        noise[1].close()
        await until(lambda: count() == 0)


async def test_a_silent_connection_counts_as_a_connection() -> None:
    async with stage(FoxgloveSettings(port=0, limits=FoxgloveLimits(clients=1, others=0))) as there:
        _, writer = await shaken(there.gateway.port)
        reader, second = await open_connection(there.gateway.port, b"")
        assert await ended(reader) == b""
        writer.close()
        second.close()


async def test_a_message_in_pieces_is_whole_again() -> None:
    async with stage() as there:
        reader, writer = await shaken(there.gateway.port)
        text = b'{"op": "getParameters", "parameterNames": [], "id": "pieces"}'
        for piece in (frame(1, text[:5], fin=False), frame(9, b"ping"), frame(0, text[5:])):
            for byte in piece:
                writer.write(bytes((byte,)))
                await asyncio.sleep(0)
        received = b""
        async with asyncio.timeout(TIMEOUT_S):
            while b'"id":"pieces"' not in received:
                received += await reader.read(4096)
        assert b"\x8a\x04ping" in received
        writer.close()


async def test_a_message_that_is_too_large_ends_the_connection_alone() -> None:
    settings = FoxgloveSettings(port=0, limits=FoxgloveLimits(message_bytes=1000))
    async with stage(settings) as there, there.client() as other:
        reader, writer = await shaken(there.gateway.port)
        writer.write(frame(2, bytes(2000)))
        assert struct.pack(">H", 1009) in await ended(reader)
        writer.close()
        await other.say("getParameters", parameterNames=[], id="here")
        await other.wait("parameterValues")


async def test_who_does_not_answer_pings_is_given_up() -> None:
    settings = FoxgloveSettings(port=0, limits=FoxgloveLimits(ping_period_s=0.05))
    async with stage(settings) as there:
        reader, writer = await shaken(there.gateway.port)
        assert b"\x89\x00" in await ended(reader)
        await until(lambda: there.connection_count == 0)
        writer.close()


async def test_who_does_not_read_answers_is_given_up() -> None:
    limits = replace(FoxgloveLimits(), control_bytes=1 << 20, calls=1000)
    async with stage(FoxgloveSettings(port=0, limits=limits)) as there:
        await there.robot.set_param("/large", "x" * 200_000)
        _, writer = await shaken(there.gateway.port)
        await until(lambda: there.connection_count == 1)
        request = frame(1, b'{"op": "getParameters", "parameterNames": ["/large"], "id": "1"}')
        writer.write(request * 100)
        await until(lambda: there.connection_count == 0)
        writer.close()


async def test_an_encrypted_connection_ends_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection_module, "_CLOSE_S", 3600.0)
    certificate, key = _certificate(tmp_path)
    settings = FoxgloveSettings(port=0, certificate=certificate, key=key)
    trust = ssl.create_default_context(cafile=certificate)
    async with stage(settings) as there:
        url = f"wss://localhost:{there.gateway.port}"
        protocol = Subprotocol("foxglove.sdk.v1")
        viewer = await connect(
            url, ssl=trust, subprotocols=[protocol], proxy=None, close_timeout=2 * TIMEOUT_S
        )
        await viewer.recv()
        await asyncio.wait_for(viewer.close(), TIMEOUT_S)
        assert viewer.close_code == 1000


async def test_random_bytes_after_the_handshake_leave_the_gateway_up() -> None:
    async with stage() as there, there.client() as other:
        for _ in range(30):
            reader, writer = await shaken(there.gateway.port)
            writer.write(os.urandom(300))
            writer.write_eof()
            await ended(reader)
            writer.close()
        await other.say("getParameters", parameterNames=[], id="here")
        await other.wait("parameterValues")
        await until(lambda: there.connection_count == 1)


def _certificate(folder: Path) -> tuple[str, str]:
    certificate, key = str(folder / "cert.pem"), str(folder / "key.pem")
    subprocess.run(
        [
            *("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"),
            *("-nodes", "-days", "2", "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"),
            *("-keyout", key, "-out", certificate),
        ],
        check=True,
        capture_output=True,
    )
    return certificate, key


@pytest.mark.skipif(not hasattr(socket, "TCP_NOTSENT_LOWAT"), reason="this system lacks the option")
async def test_messages_for_a_slow_client_do_not_wait_in_the_kernel() -> None:
    async with stage() as there:
        _, writer = await shaken(there.gateway.port)
        (connection,) = there.gateway._server._connections
        assert connection._transport is not None
        opened = connection._transport.get_extra_info("socket")
        limit = opened.getsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT)
        assert limit == connection._limits.unsent_bytes
        writer.close()


async def test_pongs_do_not_fill_memory_when_the_client_does_not_read() -> None:
    async with stage() as there:
        reader, writer = await shaken(there.gateway.port)
        (connection,) = there.gateway._server._connections
        assert connection._transport is not None
        connection._transport.set_write_buffer_limits(high=1000)
        ours = cast(asyncio.Transport, writer.transport)
        ours.pause_reading()
        pings = b"".join(frame(9, b"%125d" % number) for number in range(1000))
        async with asyncio.timeout(TIMEOUT_S):
            while not connection._pong:
                writer.write(pings)
                await writer.drain()
            size = connection.unsent_bytes
            for _ in range(10):
                writer.write(pings)
                await writer.drain()
        writer.write(frame(9, b"last"))
        await until(lambda: connection._pong.endswith(b"last"))
        assert connection.unsent_bytes <= size
        # A client that reads again gets the answer to its last ping.
        ours.resume_reading()
        tail = b""
        async with asyncio.timeout(TIMEOUT_S):
            while not tail.endswith(b"\x8a\x04last"):
                tail = (tail + await reader.read(65536))[-6:]
        writer.close()


async def test_reads_stay_so_short_that_small_frames_do_not_hold_the_loop() -> None:
    async with stage() as there:
        _, writer = await shaken(there.gateway.port)
        (connection,) = there.gateway._server._connections
        # Reads grow while they take little time.
        for _ in range(1000):
            connection._turn.note_cost(len(connection.get_buffer(-1)), 0.0)
        # A frame takes up to 10 µs.
        assert len(connection.get_buffer(-1)) / len(frame(2, b"x")) * 10e-6 < MAX_HELD_S
        writer.close()


async def test_empty_frames_of_a_message_take_no_memory() -> None:
    async with stage() as there:
        reader, writer = await shaken(there.gateway.port)
        (connection,) = there.gateway._server._connections
        writer.write(frame(1, b'{"op": ', fin=False) + frame(0, b"", fin=False) * 10_000 + frame(9, b"there"))
        await asyncio.wait_for(reader.readuntil(b"there"), TIMEOUT_S)
        assert len(connection._assembler.incomplete) == 7
        writer.write(frame(0, b'"nonsense"}'))
        await asyncio.wait_for(reader.readuntil(b"nonsense"), TIMEOUT_S)
        writer.close()
