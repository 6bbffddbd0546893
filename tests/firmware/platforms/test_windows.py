"""The node as a Windows program in wine: TCP and a COM port, through the real bridge."""

from __future__ import annotations

import asyncio
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from firmware.platforms.meeting import meeting
from firmware.platforms.programs import running

pytestmark = [pytest.mark.mingw, pytest.mark.wine, pytest.mark.timeout(300)]


@pytest.fixture
def wine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """The environment of a Windows of our own, which takes some seconds to make: one test uses it."""
    prefix = tmp_path_factory.mktemp("wine")
    # Without them it would offer to fetch .NET and a browser.
    environment = {"WINEPREFIX": str(prefix), "WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree=;mshtml="}
    everything = {**os.environ, **environment}
    null = subprocess.DEVNULL
    subprocess.run(["wineboot", "--init"], env=everything, check=True, stdin=null, stdout=null, stderr=null)
    yield environment
    subprocess.run(["wineserver", "--kill"], env=everything, check=False, stdout=null, stderr=null)


async def test_exchanges_messages_over_tcp_reconnects_and_exchanges_messages_over_a_com_port(
    windows_program: Path, wine: dict[str, str], tmp_path: Path
) -> None:
    async with meeting() as met:
        async with met.bridge("tcp://127.0.0.1:0") as (address,):
            pass
        async with running("wine", windows_program, address.removeprefix("tcp://"), environment=wine):
            for _ in range(2):
                async with met.bridge(address):
                    await met.exchange_messages()
                await asyncio.sleep(0.5)
        port = tmp_path / "port"
        async with met.bridge(f"pty:{port}"):
            # Beyond COM9, which needs the long form of the name.
            (Path(wine["WINEPREFIX"]) / "dosdevices" / "com33").symlink_to(port)
            async with running("wine", windows_program, "COM33", "115200", environment=wine):
                await met.exchange_messages()
