"""TLS and pre-shared keys on real sockets: a board without them cannot send any rosserial byte."""

from __future__ import annotations

import asyncio
import gc
import shutil
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import cast

import pytest

from rostether.errors import ConfigError, TransportError, TransportOpenError
from rostether.transports import greeting, tcp
from rostether.transports.address import TcpAddress
from rostether.transports.address_parser import parse_address
from rostether.transports.opening import open_transport
from rostether.transports.tcp import TcpListener
from tls_handshakes import handshakes_in_memory
from unit.transports.recorder import Arrivals, Recorder
from unit.transports.strangers import is_hung_up
from waiting import until


@pytest.fixture
def key(tmp_path: Path) -> Path:
    file = tmp_path / "key.txt"
    file.write_text("0123456789abcdef0123456789abcdef\n")
    return file


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two self-signed certificates, of a listener on 127.0.0.1 and of a board."""
    if shutil.which("openssl") is None:
        pytest.skip("needs openssl to make certificates")
    folder = tmp_path_factory.mktemp("certificates")
    for name in ("server", "board"):
        subprocess.run(
            [
                *("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"),
                *("-nodes", "-days", "2", "-subj", f"/CN={name}"),
                *("-addext", "subjectAltName=IP:127.0.0.1"),
                *("-keyout", folder / f"{name}.key", "-out", folder / f"{name}.pem"),
            ],
            check=True,
            capture_output=True,
        )
    return folder


@asynccontextmanager
async def listening(text: str) -> AsyncIterator[tuple[TcpListener, Arrivals, int]]:
    arrivals = Arrivals()
    address = parse_address(text)
    assert isinstance(address, TcpAddress)
    listener = await TcpListener.start(address, arrivals)
    try:
        yield listener, arrivals, int(listener.address.rpartition(":")[2])
    finally:
        await listener.close()


async def carry(arrivals: Arrivals, text: str) -> None:
    """Connect, and check that bytes pass both ways, including those in one piece with the greeting."""
    board, board_seen = await open_transport(text), Recorder()
    try:
        board.start(board_seen)
        board.write(b"from board")
        host, host_seen = await arrivals.next_started()
        await host_seen.until_received(b"from board")
        host.write(b"x" * 200_000)
        await until(lambda: len(board_seen.data) == 200_000)
    finally:
        board.close()
        await board.wait_closed()
    await host_seen.until_lost()


async def test_a_board_with_the_key_is_admitted(key: Path) -> None:
    async with listening(f"tcp://:0?psk={key}") as (listener, arrivals, port):
        await carry(arrivals, f"tcp://:{port}?connect=yes&psk={key}")
        assert listener.refusals.count == 0


async def test_a_board_with_another_key_is_refused(key: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.txt"
    other.write_text("f" * 32)
    async with listening(f"tcp://:0?psk={key}") as (listener, arrivals, port):
        with pytest.raises(TransportOpenError, match="closed the connection during the pre-shared-key hello"):
            await open_transport(f"tcp://:{port}?connect=yes&psk={other}")
        assert (arrivals.count, listener.refusals.count) == (0, 1)
        await until(lambda: listener.connection_count == 0)


async def test_a_board_without_a_key_is_refused_in_one_line(
    key: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with listening(f"tcp://:0?psk={key}") as (listener, arrivals, port):
        for _ in range(3):
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            assert (await reader.readline()).startswith(b"RSPSK1 ")
            writer.write(b"\xff\xfe\x00\x00\xff\x00\x00\xff" * 30)
            assert await is_hung_up(reader)
            writer.close()
        assert (arrivals.count, listener.refusals.count) == (0, 3)
    assert len(caplog.records) == 1
    assert "it sent no pre-shared-key hello; give it the key" in caplog.records[0].getMessage()


async def test_a_silent_client_is_dropped(key: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(greeting, "PSK_LIMIT_S", 0.05)
    async with listening(f"tcp://:0?psk={key}") as (listener, arrivals, port):
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        await reader.readline()
        assert await is_hung_up(reader)
        writer.close()
        assert (arrivals.count, listener.refusals.count) == (0, 1)


async def test_closing_in_the_middle_of_a_hello_ends_it(key: Path) -> None:
    async with listening(f"tcp://:0?psk={key}") as (listener, arrivals, port):
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        await reader.readline()
        async with asyncio.timeout(60):
            await listener.close()
        assert await is_hung_up(reader)
        writer.close()
        assert arrivals.count == 0


async def test_tls_with_a_server_certificate(certificates: Path) -> None:
    server = f"tls://:0?cert={certificates}/server.pem&key={certificates}/server.key"
    async with listening(server) as (listener, arrivals, port):
        assert listener.address == f"tls://127.0.0.1:{port}"
        await carry(arrivals, f"tls://:{port}?connect=yes&ca={certificates}/server.pem")
        with pytest.raises(TransportOpenError, match=r"no TLS connection: .*self.signed certificate"):
            await open_transport(f"tls://:{port}?connect=yes")
        await until(lambda: listener.connection_count == 0)


async def test_new_connections_use_a_certificate_that_was_replaced(
    certificates: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    certificate, key = tmp_path / "live.pem", tmp_path / "live.key"

    def replace(name: str) -> None:
        shutil.copy(certificates / f"{name}.key", key)
        shutil.copy(certificates / f"{name}.pem", certificate)

    replace("server")
    async with listening(f"tls://:0?cert={certificate}&key={key}") as (_, arrivals, port):
        await carry(arrivals, f"tls://:{port}?connect=yes&ca={certificates}/server.pem")
        # The certificate is new, its key is still the old one; then the key is half-written.
        shutil.copy(certificates / "board.pem", certificate)
        faults = [f"{key} is not the key of the certificate {certificate}; give the right one"]
        for _ in range(2):
            await carry(arrivals, f"tls://:{port}?connect=yes&ca={certificates}/server.pem")
        key.write_text("")
        faults.append(f"{key} contains no private key in PEM format; add it, or give its file")
        for _ in range(2):
            await carry(arrivals, f"tls://:{port}?connect=yes&ca={certificates}/server.pem")
        assert caplog.messages == [
            f"New connections still use the previous certificate: {each}" for each in faults
        ]
        replace("board")
        await carry(arrivals, f"tls://:{port}?connect=yes&ca={certificates}/board.pem")
        with pytest.raises(TransportOpenError, match="no TLS connection"):
            await open_transport(f"tls://:{port}?connect=yes&ca={certificates}/server.pem")


async def test_tls_with_client_certificates(certificates: Path) -> None:
    server = (
        f"tls://:0?cert={certificates}/server.pem&key={certificates}/server.key&ca={certificates}/board.pem"
    )
    async with listening(server) as (listener, arrivals, port):
        board = f"tls://:{port}?connect=yes&ca={certificates}/server.pem"
        await carry(arrivals, f"{board}&cert={certificates}/board.pem&key={certificates}/board.key")
        try:
            # In TLS 1.3 a board learns that it was refused when it reads.
            refused = await open_transport(board)
        except TransportError:
            pass
        else:
            seen = Recorder()
            refused.start(seen)
            await seen.until_lost()
        await until(lambda: listener.refusals.count == 1)
        assert arrivals.count == 1


async def test_tls_and_key_together(certificates: Path, key: Path) -> None:
    server = f"tls://:0?cert={certificates}/server.pem&key={certificates}/server.key&psk={key}"
    async with listening(server) as (_, arrivals, port):
        await carry(arrivals, f"tls://:{port}?connect=yes&ca={certificates}/server.pem&psk={key}")


async def test_a_plain_board_at_a_tls_listener_is_refused(
    certificates: Path, caplog: pytest.LogCaptureFixture
) -> None:
    server = f"tls://:0?cert={certificates}/server.pem&key={certificates}/server.key"
    async with listening(server) as (listener, arrivals, port), handshakes_in_memory() as handshakes:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(b"\xff\xfe\x00\x00\xff\x00\x00\xff")
        async with asyncio.timeout(60):
            await reader.read()
        writer.close()
        await until(lambda: listener.refusals.count == 1)
        assert "no TLS connection: the other side does not speak TLS; use tls: on both sides" in caplog.text
        assert (arrivals.count, listener.connection_count) == (0, 0)
        await until(lambda: handshakes() == 0)
        silent = await asyncio.gather(*(asyncio.open_connection("127.0.0.1", port) for _ in range(40)))
        await until(lambda: listener.refusals.count == 41 - tcp.MAX_UNPROVEN_PER_HOST)
        await until(lambda: handshakes() == tcp.MAX_UNPROVEN_PER_HOST)
        reports: list[object] = []
        asyncio.get_running_loop().set_exception_handler(lambda _loop, report: reports.append(report))
        silent.append(await asyncio.open_connection("127.0.0.1", port))
        await until(lambda: listener.refusals.count == 42 - tcp.MAX_UNPROVEN_PER_HOST)
        await until(lambda: len(listener._greetings) == tcp.MAX_UNPROVEN_PER_HOST)
        gc.collect()
        assert reports == [], "displaced in its handshake"
        for _, writer in silent:
            writer.close()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("tls://:0", "a tls: listener needs a certificate"),
        (
            "tls://:0?cert=/none.pem",
            "cannot read /none.pem: No such",
        ),
        ("tcp://:0?psk=/none", "cannot read psk=/none: "),
    ],
)
async def test_files_that_cannot_be_read_are_named(text: str, reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        await TcpListener.start(cast(TcpAddress, parse_address(text)), Arrivals())


async def test_silent_connections_of_one_address_do_not_block_others(
    key: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(greeting, "PSK_LIMIT_S", 600.0)
    async with listening(f"tcp://:0?psk={key}") as (listener, arrivals, port):
        silent = [await asyncio.open_connection("127.0.0.1", port) for _ in range(200)]
        await until(lambda: listener.connection_count <= 16)
        await carry(arrivals, f"tcp://:{port}?connect=yes&psk={key}")
        for _, writer in silent:
            writer.close()


async def test_silent_connections_of_one_address_do_not_replace_those_of_others(
    key: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tcp, "MAX_UNPROVEN_PER_HOST", 2)
    async with listening(f"tcp://0.0.0.0:0?psk={key}") as (listener, _, port):
        other = await asyncio.open_connection("127.0.0.1", port, local_addr=("127.0.0.2", 0))
        assert (await other[0].readline()).startswith(b"RSPSK1 ")
        silent = [await asyncio.open_connection("127.0.0.1", port) for _ in range(20)]
        await until(lambda: listener.connection_count == 3)
        assert {each.host for each in listener._unproven} == {"127.0.0.1", "127.0.0.2"}
        for _, writer in [other, *silent]:
            writer.close()
