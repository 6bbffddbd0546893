"""`doctor` as a process, at pseudo-terminals whose other end is a board, another device or nothing."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from interop.ros1_peers import free_port
from rostether.device import Device
from rostether.rosserial.device_link import DeviceLinkConfig
from rostether.transports.opening import open_transport
from rostether.transports.transport import Transport
from unit.bridge.sketch_board import SketchBoard, every, hello, publish
from unit.cli.command_shell import Shell

pytestmark = pytest.mark.slow


async def doctor(*arguments: str, cwd: Path | None = None) -> tuple[int, str, str]:
    """Run the command; return its exit code, its output and its lines on stderr."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "rostether",
        "doctor",
        *arguments,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=cwd,
    )
    out, err = await process.communicate()
    assert process.returncode is not None
    assert "Traceback" not in err.decode()
    return process.returncode, out.decode(), err.decode()


async def examined(
    path: Path, make_board: Callable[[Transport], SketchBoard] | None, *findings: str
) -> tuple[int, list[dict[str, Any]]]:
    """Connect a board to a pseudo-terminal; return the doctor's exit code and records.

    On a busy machine, the doctor watches for longer, until it has the findings.
    """
    transport = await open_transport(f"pty:{path}")
    board = make_board(transport).plug_in() if make_board is not None else None
    for seconds in ("2", "10", "40"):
        code, out, _ = await doctor(str(path), "--seconds", seconds, "--json")
        records = [json.loads(line) for line in out.splitlines()]
        if tuple(each["finding"] for each in records[:-1]) == findings:
            break
    if board is not None:
        await board.unplug()
    transport.close()
    await transport.wait_closed()
    return code, records


def talker(transport: Transport, config: DeviceLinkConfig | None = None) -> SketchBoard:
    return SketchBoard(transport, config=config, turn=every(0.1, publish("chatter", hello))).publisher(
        "chatter"
    )


def printer(transport: Transport) -> SketchBoard:
    board = SketchBoard(transport, turn=every(0.5, lambda it: it.write(b"Temperature: 21.5 C\r\n")))
    board.data_received = lambda data: None  # type: ignore[method-assign]
    return board


def stale(transport: Transport) -> SketchBoard:
    return talker(transport).publisher("range", "sensor_msgs/Range", "1" * 32)


async def test_boards_at_ports(tmp_path: Path) -> None:
    well, silent, text, old, outdated = await asyncio.gather(
        examined(tmp_path / "well", talker),
        examined(tmp_path / "silent", None, "nothing-received"),
        examined(tmp_path / "text", printer, "text-received"),
        examined(
            tmp_path / "old", lambda wire: talker(wire, DeviceLinkConfig(version=1)), "protocol-version"
        ),
        examined(tmp_path / "stale", stale, "stale-headers"),
    )
    code, records = well
    assert (code, len(records)) == (0, 1)
    assert records[0]["healthy"] is True
    (endpoint,) = records[0]["board"]["endpoints"]
    assert (endpoint["name"], endpoint["type"]) == ("chatter", "std_msgs/String")
    assert endpoint["rate_hz"] > 0
    for (code, records), expected in (
        (silent, "nothing-received"),
        (text, "text-received"),
        (old, "protocol-version"),
        (outdated, "stale-headers"),
    ):
        assert code == 1
        assert [each["finding"] for each in records[:-1]] == [expected]
        assert records[0]["seen"]
        assert records[0]["next_step"]
        assert records[-1]["findings"] == [expected]
    assert "Temperature: 21.5 C" in text[1][0]["seen"]
    assert "1" * 32 in outdated[1][0]["seen"]
    assert silent[1][-1]["board"] is None


async def test_a_port_that_another_process_has() -> None:
    master, slave = os.openpty()
    path = os.ttyname(slave)
    os.close(slave)
    with open(path, "rb") as port:  # noqa: PTH123
        holder = subprocess.Popen(["sleep", "60"], stdin=port)
    try:
        code, out, _ = await doctor(path)
        assert code == 1
        assert f"error busy: {path} is in use by sleep (PID {holder.pid})" in out
        assert f"kill {holder.pid}" in out
    finally:
        holder.kill()
        holder.wait()
        os.close(master)


async def test_an_address_that_another_process_has() -> None:
    with open(os.devnull) as nothing:  # noqa: PTH123
        program = (
            "import socket, time; s = socket.create_server(('127.0.0.1', 0)); "
            "print(s.getsockname()[1], flush=True); time.sleep(60)"
        )
        other = subprocess.Popen(
            [sys.executable, "-c", program], stdin=nothing, stdout=subprocess.PIPE, text=True
        )
    try:
        assert other.stdout is not None
        port = other.stdout.readline().strip()
        code, out, _ = await doctor(f"tcp://127.0.0.1:{port}")
        assert code == 1
        assert "error busy" in out
        assert f"(PID {other.pid})" in out
    finally:
        other.kill()
        other.communicate()


async def test_a_port_that_the_user_may_not_open() -> None:
    if os.getuid() != 0:
        pytest.skip("only root can change its user")
    master, slave = os.openpty()
    path = os.ttyname(slave)
    Path(path).chmod(0o600)
    # Imports first: the unprivileged user may not read all modules.
    program = f"""
import concurrent.futures.thread, difflib, grp, os, sys, tty
import rostether.bridge.health.doctor, rostether.cli.bridge.doctor, rostether.cli.bridge.doctor_report
import rostether.transports.serial, rostether.msgdef.registry
from rostether.cli.main import main
os.setgroups([]); os.setgid(65534); os.setuid(65534)
sys.exit(main(["doctor", {path!r}]))
"""
    try:
        answer = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    finally:
        os.close(slave)
        os.close(master)
    assert answer.returncode == 1, answer.stderr
    assert f"error no-permission: no permission to open {path}" in answer.stdout
    assert "next: run: sudo" in answer.stdout


def test_no_such_port_with_near_names(shell: Shell, tmp_path: Path) -> None:
    (tmp_path / "ttyACM0").touch()
    code = shell("doctor", str(tmp_path / "ttyACM1"))
    assert code.code == 1
    assert "error no-port" in code.out
    assert f"did you mean {tmp_path}/ttyACM0?" in code.out


def test_a_file(shell: Shell, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    result = shell("doctor", str(tmp_path / "file"))
    assert result.code == 1
    assert "error not-a-port" in result.out


async def test_a_board_that_connects_over_tcp() -> None:
    port = free_port()
    async with Device(f"tcp://127.0.0.1:{port}") as device:
        device.publisher("count", "std_msgs/UInt32")
        code, out, err = await doctor(f"tcp://127.0.0.1:{port}", "--seconds", "1")
    assert code == 0, out
    assert "publisher count [std_msgs/UInt32], 0.0 Hz" in out
    assert "no problem found" in out
    assert "waiting" in err


async def test_no_connection() -> None:
    code, out, _ = await doctor(f"tcp://127.0.0.1:{free_port()}", "--seconds", "1")
    assert code == 1
    assert "error nobody-connected" in out
    assert "cannot reach loopback" in out


async def test_no_listener_at_the_address() -> None:
    code, out, _ = await doctor(f"tcp://127.0.0.1:{free_port()}?connect=yes")
    assert code == 1
    assert "error cannot-open" in out


def test_an_address_that_makes_no_sense(shell: Shell) -> None:
    result = shell("doctor", "ttyACM0")
    assert result.code == 1
    assert "/dev/ttyACM0" in result.err


def test_without_a_port_boards_are_looked_for(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.transports.serial.list_ports", list)
    result = shell("doctor")
    assert result.code == 1
    assert "no board found on USB" in result.err
