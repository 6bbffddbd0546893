"""`monitor` as a process, in a terminal and without one, with a bridge on the graph."""

from __future__ import annotations

import asyncio
import json
import os
import pty
import signal
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from programs import started
from rostether.cli.bridge.doctor import _doctor
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.master_client import MasterClient
from rostether.transports.opening import open_transport
from unit.bridge.sketch_board import SketchBoard, every, hello, publish
from unit.cli.command_shell import LiveGraph, Shell

pytestmark = pytest.mark.slow


@asynccontextmanager
async def bridged(folder: Path) -> AsyncIterator[dict[str, str]]:
    """A bridge with a board that publishes ten messages per second."""
    master = await MasterServer.start(port=0)
    wire = await open_transport(f"pty:{folder}/arm")
    board = SketchBoard(wire, turn=every(0.1, publish("chatter", hello))).publisher("chatter").plug_in()
    environ = {"ROS_MASTER_URI": master.uri}
    try:
        async with started("serve", f"{folder}/arm", **environ) as serve:
            await serve.wait_for("Setup publisher on chatter")
            client = MasterClient(master.uri, "/test")
            while "/diagnostics" not in (await client.system_state())[0]:
                await asyncio.sleep(0.05)
            await client.close()
            yield environ
    finally:
        await board.unplug()
        await master.close()


async def test_one_table_and_objects_without_a_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    async with (
        asyncio.timeout(60),
        bridged(tmp_path) as environ,
        started("monitor", **environ) as table,
        started("monitor", "--once", "--json", **environ) as record,
    ):
        text = await table.finish()
        assert table.process.returncode == 0
        head, row, topic = text.splitlines()
        assert head.split()[:2] == ["BOARD", "STATE"]
        assert row.split()[:2] == ["/arm", "connected"]
        words = topic.split()
        assert words[:3] == ["->", "chatter", "std_msgs/String"]
        # 10 a second; a busy machine lets them come in bursts.
        assert float(words[3]) >= 0
        assert words[4] == "Hz"
        (board,) = [json.loads(line) for line in (await record.finish()).splitlines()]
        assert (board["name"], board["state"], board["findings"]) == ("/arm", "connected", [])
        assert board["endpoints"][0]["name"] == "chatter"
        # Without a board on USB, doctor reports the boards of the bridge that runs.
        monkeypatch.setattr("rostether.transports.serial.list_ports", list)
        monkeypatch.setenv("ROS_MASTER_URI", environ["ROS_MASTER_URI"])
        assert await _doctor(None, None, (), as_json=False) == 0
        lines = capsys.readouterr().out.splitlines()
        assert lines[0] == f"/arm, on a running bridge at {environ['ROS_MASTER_URI']}"
        assert "    publisher chatter [std_msgs/String], " in lines[2]
        assert lines[3] == "  no problem found"
        assert await _doctor(None, None, (), as_json=True) == 0
        assert json.loads(capsys.readouterr().out)["healthy"] is True


async def test_json_continues(tmp_path: Path) -> None:
    async with bridged(tmp_path) as environ, started("monitor", "--json", **environ) as monitor:
        await monitor.wait_for(lambda lines: len(lines) >= 3)
        assert {json.loads(line)["name"] for line in monitor.lines} == {"/arm"}
        await monitor.stop(signal.SIGINT)
        assert monitor.process.returncode == 130


async def test_live_in_a_terminal(tmp_path: Path) -> None:
    async with asyncio.timeout(60), bridged(tmp_path) as environ:
        controller, terminal = pty.openpty()
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            "rostether",
            "monitor",
            env={**os.environ, "TERM": "xterm", "COLUMNS": "80", "LINES": "24", **environ},
            stdin=terminal,
            stdout=terminal,
            stderr=subprocess.STDOUT,
        )
        os.close(terminal)
        os.set_blocking(controller, False)
        seen = ""
        try:
            # Two pictures: the table stays, its figures change.
            while seen.count("/arm") < 2 or " Hz" not in seen.rpartition("/arm")[2]:
                assert process.returncode is None, seen
                await asyncio.sleep(0.05)
                try:
                    seen += os.read(controller, 65536).decode()
                except BlockingIOError:
                    continue
            assert "1 board on http://" in seen
            assert "no board publishes on /diagnostics" not in seen.rpartition("/arm")[2]
            process.send_signal(signal.SIGINT)
            while process.returncode is None:
                await asyncio.sleep(0.05)
                try:
                    seen += os.read(controller, 65536).decode()
                except OSError:
                    continue
            assert process.returncode == 130
            assert "Traceback" not in seen
        finally:
            if process.returncode is None:
                process.kill()
                await process.wait()
            os.close(controller)


def test_no_board_to_monitor(shell: Shell, graph: LiveGraph) -> None:
    result = shell("monitor")
    assert result.code == 1
    assert result.out == ""
    (line,) = result.err.splitlines()
    assert "start `rostether serve`" in line


def test_no_master(shell: Shell) -> None:
    assert "start one with `rostether core` or `rostether serve`" in shell.failure("monitor", "--once")
