"""What `serve` reports about an unhealthy board: lines, and /diagnostics on the ROS 1 graph."""

from __future__ import annotations

import asyncio
from pathlib import Path

from programs import started
from rostether.joining import join
from rostether.ros1.master.server import MasterServer
from rostether.transports.opening import open_transport
from unit.bridge.sketch_board import SketchBoard, every, hello, publish


async def test_findings_in_the_log_once_and_in_diagnostics(tmp_path: Path) -> None:
    master = await MasterServer.start(port=0)
    wire = await open_transport(f"pty:{tmp_path}/board")
    board = SketchBoard(wire, turn=every(0.3, lambda it: it.write(b"distance 42 cm\r\n"))).plug_in()
    environ = {"ROS_MASTER_URI": master.uri}
    try:
        async with (
            asyncio.timeout(60),
            started("serve", f"{tmp_path}/board?name=arm", **environ) as serve,
            join("looker", environ=environ) as graph,
        ):
            await serve.wait_for("text between the frames")
            reported = 0
            async for array in graph.messages("/diagnostics", "diagnostic_msgs/DiagnosticArray"):
                (status,) = array.status
                assert (status.name, status.level) == ("arm: rosserial", 1)
                assert "distance 42 cm" in status.message
                assert {each.key: each.value for each in status.values}["state"] == "connected"
                reported += 1
                if reported == 3:
                    break
        assert serve.text.count("text between the frames") == 1
    finally:
        await board.unplug()
        await master.close()


async def test_diagnostics_can_be_omitted(tmp_path: Path) -> None:
    master = await MasterServer.start(port=0)
    wire = await open_transport(f"pty:{tmp_path}/board")
    board = SketchBoard(wire, turn=every(0.3, publish("chatter", hello))).publisher("chatter").plug_in()
    environ = {"ROS_MASTER_URI": master.uri}
    try:
        async with (
            asyncio.timeout(60),
            started("serve", "--no-diagnostics", f"{tmp_path}/board", **environ) as serve,
            join("looker", environ=environ) as graph,
        ):
            await serve.wait_for("Setup publisher on chatter")
            async for _ in graph.messages("/chatter", "std_msgs/String"):
                break
            await asyncio.sleep(1.5)
            assert "/diagnostics" not in (await graph.snapshot()).topics
    finally:
        await board.unplug()
        await master.close()
