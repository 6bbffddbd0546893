"""Large meshes, for clients that read them fast, slowly or not at all."""

from __future__ import annotations

import asyncio
import time
from contextlib import AsyncExitStack
from pathlib import Path

import pytest

import rostether.gateways.foxglove.client_sender as sender_module
from rostether.gateways.foxglove.settings import FoxgloveLimits, FoxgloveSettings
from unit.gateways.foxglove.protocol_client import stage
from waiting import until


async def test_all_meshes_of_a_robot_come_however_large_and_many_they_are(tmp_path: Path) -> None:
    (tmp_path / "mesh.stl").write_bytes(bytes(6 << 20))
    limits = FoxgloveLimits(control_bytes=1 << 20, calls=2)
    async with (
        stage(FoxgloveSettings(port=0, limits=limits), find_packages=lambda: {"arm": tmp_path}) as there,
        there.client() as client,
    ):
        for number in range(5):
            await client.say("fetchAsset", uri="package://arm/mesh.stl", requestId=number)
        await until(lambda: len(client.of("fetchAssetResponse")) == 5)
        assert {len(each["data"]) for each in client.of("fetchAssetResponse")} == {6 << 20}


async def test_clients_that_do_not_read_large_meshes_do_not_keep_them_from_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sender_module, "_LARGE_STEP_S", 0.3)
    (tmp_path / "mesh.stl").write_bytes(bytes(12 << 20))
    async with stage(find_packages=lambda: {"arm": tmp_path}) as there, AsyncExitStack() as clients:
        silent = [await clients.enter_async_context(there.client(close_timeout=0.1)) for _ in range(4)]
        for client in silent:
            client.connection.transport.pause_reading()
            await client.say("fetchAsset", uri="package://arm/mesh.stl", requestId=1)
        await until(lambda: there.gateway.context.assets._large_room.locked())
        reader = await clients.enter_async_context(there.client())
        await reader.say("fetchAsset", uri="package://arm/mesh.stl", requestId=1)
        assert len((await reader.wait("fetchAssetResponse"))["data"]) == 12 << 20
        await until(lambda: len(there.gateway._clients) == 1)


async def test_a_client_that_reads_a_large_mesh_slowly_gets_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sender_module, "_LARGE_STEP_S", 0.5)
    monkeypatch.setattr(sender_module, "_LARGE_STEP_BYTES", 1)
    (tmp_path / "mesh.stl").write_bytes(bytes(10 << 20))
    async with (
        stage(find_packages=lambda: {"arm": tmp_path}) as there,
        there.client(ping_interval=None) as client,
    ):
        began_s = time.monotonic()
        await client.say("fetchAsset", uri="package://arm/mesh.stl", requestId=1)
        transport = client.connection.transport
        while not client.of("fetchAssetResponse") and not client._reading.done():
            transport.pause_reading()
            await asyncio.sleep(0.05)
            transport.resume_reading()
            # The event loop reads once, at most 256 KiB.
            for _ in range(2):
                await asyncio.sleep(0)
        assert len(client.of("fetchAssetResponse")[0]["data"]) == 10 << 20
        assert time.monotonic() - began_s > 1
