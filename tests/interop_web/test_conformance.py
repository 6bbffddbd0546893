"""A client in JavaScript, written only from the page of the wire protocol, passes the conformance cases."""

from __future__ import annotations

import asyncio
import sys

from interop.ros1_peers import free_port
from interop_web.web_peers import WebPeers

TIMEOUT_S = 180.0


async def test_a_client_written_from_the_page_passes(web_peers: WebPeers) -> None:
    port = free_port()
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "rostether", "conformance", f"tcp://127.0.0.1:{port}", "--quick"),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
    )
    await web_peers.start("conformance_client.mjs", str(port))
    out, _ = await asyncio.wait_for(process.communicate(), TIMEOUT_S)
    *cases, total = out.decode().splitlines()
    assert [line for line in cases[1:] if not line.startswith("pass ")] == []
    assert total.endswith(" passed, 0 failed, 0 not applicable")
    assert process.returncode == 0
