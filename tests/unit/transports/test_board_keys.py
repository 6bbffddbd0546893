"""Boards with individual keys and certificates, over real sockets."""

from __future__ import annotations

import asyncio
import subprocess
from pathlib import Path

import pytest

from rostether.errors import ConfigError, TransportError
from rostether.ports.devices_toml import parse_devices_toml
from rostether.transports.address import TcpAddress, TlsFiles
from rostether.transports.board_keys import BoardKeys, Proof, read_board_keys
from rostether.transports.tcp import TcpListener, TcpTransport, connect_tcp
from rostether.transports.transport import Transport


class BoardListener:
    """A listener, and the transports that it has created."""

    def __init__(self) -> None:
        self.came: asyncio.Queue[Transport] = asyncio.Queue()
        self.listener: TcpListener

    async def open(self, address: TcpAddress, keys: BoardKeys) -> int:
        self.listener = await TcpListener.start(address, self.came.put_nowait, board_keys=keys)
        return int(self.listener.address.partition("?")[0].rpartition(":")[2])

    async def proof(self) -> Proof:
        transport = await asyncio.wait_for(self.came.get(), 60)
        assert isinstance(transport, TcpTransport)
        return transport.proof


def key_file(folder: Path, name: str) -> str:
    path = folder / f"{name}.key"
    path.write_text(name * 8)
    return str(path)


def certificate(folder: Path, name: str) -> tuple[str, str]:
    files = str(folder / f"{name}.pem"), str(folder / f"{name}-key.pem")
    subprocess.run(
        [
            *("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"),
            *("-nodes", "-days", "2", "-subj", f"/CN={name}", "-addext", "subjectAltName=IP:127.0.0.1"),
            *("-out", files[0], "-keyout", files[1]),
        ],
        check=True,
        capture_output=True,
    )
    return files


@pytest.mark.parametrize("shared", [True, False])
async def test_a_board_is_known_by_its_key(shared: bool, tmp_path: Path) -> None:
    left, right, all_of_them, foreign = (key_file(tmp_path, name) for name in ("left", "right", "many", "no"))
    keys = read_board_keys([left, right], [])
    boards = BoardListener()
    port = await boards.open(TcpAddress("127.0.0.1", 0, psk=all_of_them if shared else "devices"), keys)
    try:
        for file, proven in ((right, right), (left, left), *([(all_of_them, None)] if shared else [])):
            board = await connect_tcp(TcpAddress("127.0.0.1", port, connect=True, psk=file))
            assert await boards.proof() == Proof(proven)
            board.abort()
            await board.wait_closed()
        for file in (foreign, *([] if shared else [all_of_them])):
            with pytest.raises(TransportError):
                await connect_tcp(TcpAddress("127.0.0.1", port, connect=True, psk=file))
    finally:
        await boards.listener.close()


async def test_a_board_is_known_by_its_certificate(tmp_path: Path) -> None:
    cert, key = certificate(tmp_path, "bridge")
    left, right, foreign = (certificate(tmp_path, name) for name in ("left", "right", "foreign"))
    boards = BoardListener()
    address = TcpAddress("127.0.0.1", 0, tls=TlsFiles(cert, key))
    port = await boards.open(address, read_board_keys([], [left[0], right[0]]))
    try:
        for files, proven in ((left, left[0]), (right, right[0]), ((None, None), None)):
            tls = TlsFiles(files[0], files[1], cert)
            board = await connect_tcp(TcpAddress("127.0.0.1", port, connect=True, tls=tls))
            assert await boards.proof() == Proof(None, proven)
            board.abort()
            await board.wait_closed()
        refused: list[TcpTransport] = []
        try:
            # With TLS 1.3, a connector detects only later that its certificate was refused.
            tls = TlsFiles(foreign[0], foreign[1], cert)
            refused.append(await connect_tcp(TcpAddress("127.0.0.1", port, connect=True, tls=tls)))
        except TransportError:
            pass
        async with asyncio.timeout(60):
            while not boards.listener.refusals.count:
                await asyncio.sleep(0.01)
        assert boards.came.empty()
        for each in refused:
            each.abort()
            await each.wait_closed()
    finally:
        await boards.listener.close()


async def test_devices_without_a_key_are_not_a_choice() -> None:
    with pytest.raises(ConfigError, match=r"psk=devices: no board has a key in devices\.toml"):
        await BoardListener().open(TcpAddress("127.0.0.1", 0, psk="devices"), BoardKeys())


def test_files_that_hold_none_are_named(tmp_path: Path) -> None:
    (tmp_path / "short").write_text("x")
    for keys, certificates, reason in (
        ([str(tmp_path / "short")], [], "short: a key has 16"),
        ([], [str(tmp_path / "short")], "contains no certificate in PEM format"),
        ([], [str(tmp_path / "none")], "cannot read certificate=.*none: No such file"),
    ):
        with pytest.raises(ConfigError, match=reason):
            read_board_keys(keys, certificates)


def test_devices_toml_names_them(tmp_path: Path) -> None:
    from rostether.bridge.identity import identify_peer

    file = key_file(tmp_path, "arm")
    book = parse_devices_toml(
        f"[devices.arm]\npsk = '{file}'\naddress = '10.0.0.1'\n[devices.leg]\npsk = 'x'"
    )
    arm = identify_peer("10.0.0.1", Proof(file))
    assert book.settings_matching(arm).name == "arm"
    assert book.settings_matching(identify_peer("10.0.0.1")).name is None, "the address alone is no proof"
    assert book.settings_matching(identify_peer("10.0.0.2", Proof(file))).name is None
    assert book.settings_matching(identify_peer("10.0.0.2", Proof("x"))).name == "leg"
    with pytest.raises(ConfigError, match="cannot read psk=x: "):
        book.board_keys()
