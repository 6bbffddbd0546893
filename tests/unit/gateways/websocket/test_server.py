from __future__ import annotations

import asyncio
import ssl
from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.gateways.foxglove.settings import FoxgloveSettings
from rostether.gateways.websocket.own_authority import own_certificate
from unit.gateways.foxglove.protocol_client import TIMEOUT_S, stage


async def test_files_that_cannot_be_used_are_named(tmp_path: Path) -> None:
    empty = tmp_path / "empty.pem"
    empty.write_text("")
    with pytest.raises(ConfigError, match=r"empty\.pem contains no certificate"):
        async with stage(FoxgloveSettings(port=0, certificate=str(empty))):
            pass


async def test_new_connections_use_a_certificate_that_was_replaced(tmp_path: Path) -> None:
    first, second = own_certificate(tmp_path / "first"), own_certificate(tmp_path / "second")
    file = tmp_path / "both.pem"
    file.write_bytes(first.certificate.read_bytes() + first.key.read_bytes())
    async with stage(FoxgloveSettings(port=0, certificate=str(file))) as there:

        async def connect(authority: Path) -> None:
            trust = ssl.create_default_context(cafile=str(authority))
            async with asyncio.timeout(TIMEOUT_S):
                _, writer = await asyncio.open_connection("localhost", there.gateway.port, ssl=trust)
            writer.close()

        await connect(first.authority)
        file.write_bytes(second.certificate.read_bytes() + second.key.read_bytes())
        await connect(second.authority)
        with pytest.raises(ssl.SSLCertVerificationError):
            await connect(first.authority)
