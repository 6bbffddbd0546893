from __future__ import annotations

from pathlib import Path

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus
from websockets.typing import Origin, Subprotocol

from interop.ros1_peers import free_port
from programs import started
from rostether.cli.gateway.options import Encryption, is_listen_address, read_encryption, read_listen_address
from rostether.cli.shell.option_group import insert_value
from rostether.errors import ConfigError
from rostether.ros1.master.server import MasterServer
from unit.cli.command_shell import Shell


@pytest.mark.parametrize(
    ("typed", "read"),
    [
        (["--rosbridge"], ["--rosbridge=localhost"]),
        (["--rosbridge", "9091"], ["--rosbridge", "9091"]),
        (["--rosbridge", "0.0.0.0:9090", "/dev/ttyACM0"], ["--rosbridge", "0.0.0.0:9090", "/dev/ttyACM0"]),
        (["--rosbridge", "[::1]:9090"], ["--rosbridge", "[::1]:9090"]),
        (["--rosbridge", "robot.local:9090"], ["--rosbridge", "robot.local:9090"]),
        (["--rosbridge", "0.0.0.0"], ["--rosbridge", "0.0.0.0"]),
        (["--rosbridge", "/dev/ttyACM0"], ["--rosbridge=localhost", "/dev/ttyACM0"]),
        (["--rosbridge", "tcp://:11411"], ["--rosbridge=localhost", "tcp://:11411"]),
        (["--rosbridge", "COM3"], ["--rosbridge=localhost", "COM3"]),
        (["--rosbridge", "--ros1"], ["--rosbridge=localhost", "--ros1"]),
        (["--rosbridge=9091", "x"], ["--rosbridge=9091", "x"]),
        (["--", "--rosbridge"], ["--", "--rosbridge"]),
    ],
)
def test_only_an_address_is_the_value_of_the_option(typed: list[str], read: list[str]) -> None:
    assert insert_value(typed, "--rosbridge", "localhost", is_listen_address) == read


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("localhost", ("localhost", 9090)),
        ("9091", ("localhost", 9091)),
        (":9091", ("localhost", 9091)),
        ("0.0.0.0", ("0.0.0.0", 9090)),
        ("0.0.0.0:9091", ("0.0.0.0", 9091)),
        ("[::1]:9091", ("::1", 9091)),
        ("[::1]", ("::1", 9090)),
        ("::1", ("::1", 9090)),
        ("robot.local:80", ("robot.local", 80)),
    ],
)
def test_listen_addresses(text: str, address: tuple[str, int]) -> None:
    assert read_listen_address(text, 9090) == address


@pytest.mark.parametrize("text", ["localhost:many", "99999", "host:99999", "host:"])
def test_wrong_listen_addresses(text: str) -> None:
    with pytest.raises(
        ConfigError, match=r"is not an address to listen on; write HOST:PORT, e.g. 0\.0\.0\.0:9090"
    ):
        read_listen_address(text, 9090)


@pytest.mark.parametrize("command", ["rosbridge", "foxglove"])
@pytest.mark.parametrize("origin", ["panel.example", "https:panel.example", "https://panel.example/page"])
def test_wrong_origins(command: str, origin: str, shell: Shell) -> None:
    assert "write it like https://panel.example or" in shell.failure(command, "--origin", origin)


@pytest.mark.parametrize("node", ["rosbridge-websocket", "foxglove-bridge"])
async def test_nodes_of_launch_files_accept_pages_of_an_origin(node: str) -> None:
    port = free_port()
    protocols = [Subprotocol("foxglove.sdk.v1")] if node == "foxglove-bridge" else None
    master = await MasterServer.start(port=0)
    try:
        words = ("--origin", "https://panel.example", f"_port:={port}", f"__master:={master.uri}")
        async with started("role", node, *words) as role:
            await role.wait_for("ws://")
            uri = f"ws://127.0.0.1:{port}"
            async with connect(uri, origin=Origin("https://panel.example"), subprotocols=protocols):
                pass
            with pytest.raises(InvalidStatus, match="403"):
                await connect(uri, origin=Origin("https://other.example"), subprotocols=protocols)
    finally:
        await master.close()


@pytest.mark.parametrize(
    ("typed", "reason"),
    [
        (("--view-token", "a"), "--view-token needs --token"),
        (("--view-token", "a", "--token", "a"), "must differ"),
    ],
)
def test_a_view_token_that_protects_nothing_is_refused(
    typed: tuple[str, ...], reason: str, shell: Shell
) -> None:
    for command in ("dashboard", "foxglove", "serve"):
        reported = shell.failure(command, *typed)
        assert reason in reported


def test_without_the_option_nothing_is_encrypted() -> None:
    assert read_encryption("", "localhost") == Encryption()


def test_a_file_holds_both() -> None:
    assert read_encryption("robot.pem", "localhost") == Encryption("robot.pem")


def test_auto_makes_a_certificate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    made = read_encryption("auto", "0.0.0.0")
    folder = tmp_path / "rostether" / "tls"
    assert made == Encryption(
        str(folder / "server.pem"), str(folder / "server.key"), folder / "authority.pem"
    )
    assert all((folder / name).exists() for name in ("server.pem", "server.key", "authority.pem"))
