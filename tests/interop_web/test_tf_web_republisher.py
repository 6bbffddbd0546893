"""Web clients of tf2_web_republisher through rosbridge, all as processes."""

from __future__ import annotations

import asyncio
import json
import signal
import sys
from contextlib import AsyncExitStack
from pathlib import Path

import pytest

from interop.ros1_peers import free_port
from programs import start_command
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.master_client import MasterClient

pytest.importorskip("roslibpy")
PEER = Path(__file__).parent / "peers" / "roslibpy_tf.py"


async def test_roslibpy_receives_the_transform_of_a_frame() -> None:
    port = free_port()
    async with AsyncExitStack() as stack:
        master = await MasterServer.start(port=0)
        stack.push_async_callback(master.close)
        environment = {"ROS_MASTER_URI": master.uri}
        for command in (
            ("rosbridge", str(port)),
            ("run", "tf2_web_republisher", "tf2_web_republisher"),
            ("role", "static-transform-publisher", "1", "2", "3", "0", "0", "0", "world", "arm"),
        ):
            peer = await start_command(*command, environment=environment)
            stack.push_async_callback(peer.stop, signal.SIGTERM)
            if command[0] == "rosbridge":
                await peer.wait_for(f":{port}")
        client = MasterClient(master.uri, "/test")
        stack.push_async_callback(client.close)
        async with asyncio.timeout(60):
            while "/republish_tfs" not in (await client.system_state())[2]:
                await asyncio.sleep(0.05)
        text = await _run_client(port)
    assert json.loads(text)["translation"] == {"x": 1.0, "y": 2.0, "z": 3.0}


async def _run_client(port: int) -> str:
    process = await asyncio.create_subprocess_exec(
        sys.executable, str(PEER), str(port), stdout=asyncio.subprocess.PIPE
    )
    async with asyncio.timeout(120):
        out, _ = await process.communicate()
    assert process.returncode == 0
    return out.decode()
