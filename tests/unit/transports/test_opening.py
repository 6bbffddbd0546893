from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rostether.errors import ConfigError, TransportOpenError
from rostether.transports.opening import listen, open_transport
from unit.transports.recorder import Arrivals, Recorder


@pytest.mark.parametrize("scheme", ["tcp", "udp"])
async def test_listen_and_connect(scheme: str) -> None:
    arrivals = Arrivals()
    listener = await listen(f"{scheme}://:0", arrivals)
    assert listener.address.startswith(f"{scheme}://127.0.0.1:")
    board = await open_transport(f"{listener.address}?connect=yes")
    board.write(b"hello")
    _, seen = await arrivals.next_started()
    await seen.until_received(b"hello")
    board.close()
    await board.wait_closed()
    await listener.close()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
async def test_a_pty_is_opened_like_a_serial_port(tmp_path: Path) -> None:
    host = await open_transport(f"pty:{tmp_path}/board")
    board = await open_transport(f"{tmp_path}/board?baud=115200")
    seen = Recorder()
    host.start(seen)
    board.write(b"hello")
    await seen.until_received(b"hello")
    for transport in (board, host):
        transport.close()
        await transport.wait_closed()


@pytest.mark.parametrize("address", ["tcp://:0", "udp://:0", "xbee:/dev/nothing"])
async def test_what_is_listened_on_is_not_opened(address: str) -> None:
    with pytest.raises(ConfigError, match="accepts many devices"):
        await open_transport(address)


@pytest.mark.parametrize("address", ["/dev/nothing", "pty:/tmp/nothing", "tcp://:1?connect=yes"])
async def test_what_is_opened_is_not_listened_on(address: str) -> None:
    with pytest.raises(ConfigError, match="is one device"):
        await listen(address, Arrivals())


async def test_a_missing_port_of_an_xbee_is_reported() -> None:
    with pytest.raises(TransportOpenError, match="no serial port /dev/nothing"):
        await listen("xbee:/dev/nothing", Arrivals())


@pytest.mark.usefixtures("cold_start")
def test_nothing_heavy_is_imported_before_it_is_needed() -> None:
    code = """
import sys
before = set(sys.modules)  # what the installation itself imports at start
import asyncio
from rostether.transports.opening import listen
async def main():
    listener = await listen("tcp://:0", print)
    await listener.close()
asyncio.run(main())
print(sorted({"serialx", "ipaddress", "rostether.transports.udp"} & set(sys.modules) - before))
"""
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
