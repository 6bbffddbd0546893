"""The node as a Windows program in wine with the real bridge, over TCP and a COM port."""

from __future__ import annotations

import asyncio
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from firmware.platforms.node_harness import node_harness
from firmware.platforms.programs import running

pytestmark = [pytest.mark.mingw, pytest.mark.wine, pytest.mark.timeout(300)]


# Debian's wine has the libraries of Windows here.
LIBRARIES = Path("/usr/lib/x86_64-linux-gnu/wine/x86_64-windows")


@pytest.fixture
def wine(tmp_path: Path) -> Iterator[dict[str, str]]:
    """The environment of a Windows with links to its libraries; copying them with `wineboot` takes
    seconds.
    """
    prefix = tmp_path / "wine"
    system = prefix / "drive_c" / "windows" / "system32"
    system.mkdir(parents=True)
    for library in LIBRARIES.iterdir():
        (system / library.name).symlink_to(library)
    (prefix / "dosdevices").mkdir()
    for drive, folder in {"c:": "../drive_c", "z:": "/"}.items():
        (prefix / "dosdevices" / drive).symlink_to(folder)
    (prefix / ".update-timestamp").write_text("disable\n")
    environment = {"WINEPREFIX": str(prefix), "WINEDEBUG": "-all"}
    yield environment
    null = subprocess.DEVNULL
    subprocess.run(
        ["wineserver", "--kill"], env={**os.environ, **environment}, check=False, stdout=null, stderr=null
    )


async def test_exchanges_messages_over_tcp_reconnects_and_exchanges_messages_over_a_com_port(
    windows_program: Path, wine: dict[str, str], tmp_path: Path
) -> None:
    async with node_harness() as harness:
        async with harness.bridge("tcp://127.0.0.1:0") as (address,):
            pass
        async with running("wine", windows_program, address.removeprefix("tcp://"), environment=wine):
            for _ in range(2):
                async with harness.bridge(address):
                    await harness.exchange_messages()
                await asyncio.sleep(0.5)
        port = tmp_path / "port"
        async with harness.bridge(f"pty:{port}"):
            # Above COM9, the long form of the name is necessary.
            (Path(wine["WINEPREFIX"]) / "dosdevices" / "com33").symlink_to(port)
            async with running("wine", windows_program, "COM33", "115200", environment=wine):
                await harness.exchange_messages()
