from __future__ import annotations

import asyncio
import sys
from pathlib import Path

import pytest

from children import is_running
from rostether.mechanisms.program import run_program, wait_or_kill


async def test_output_input_and_exit_code() -> None:
    code = "import sys; print(sys.stdin.read().upper()); print('bad', file=sys.stderr); sys.exit(3)"
    ended = await run_program([sys.executable, "-c", code], input_data=b"word", merge=False)
    assert ended == (3, b"WORD\n", b"bad\n")
    merged = await run_program([sys.executable, "-c", "print(input)"], environ={"PATH": ""})
    assert merged.code == 0
    assert merged.errors == b""


async def test_a_program_that_does_not_exist() -> None:
    with pytest.raises(FileNotFoundError):
        await run_program(["/nowhere/program"])


@pytest.mark.parametrize("ignores", ["trap '' TERM;", ""])
async def test_cancelling_ends_the_program_and_its_children(
    ignores: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.mechanisms.program.END_LIMIT_S", 0.1)
    part = tmp_path / "part"
    script = f"{ignores} sleep 600 & echo $! > {part}; mv {part} {tmp_path}/child; wait"
    task = asyncio.create_task(run_program(["sh", "-c", script]))
    child = tmp_path / "child"
    while not await asyncio.to_thread(child.exists):
        await asyncio.sleep(0.01)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    number = int(await asyncio.to_thread(child.read_text))
    while await asyncio.to_thread(is_running, number):
        await asyncio.sleep(0.01)


async def test_cancelling_while_it_starts(tmp_path: Path) -> None:
    task = asyncio.create_task(run_program(["sh", "-c", f"sleep 600; touch {tmp_path}/late"]))
    await asyncio.sleep(0)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task


@pytest.mark.parametrize(("script", "code"), [("exit 3", 3), ("exec sleep 600", -9)])
async def test_a_program_that_does_not_end_is_killed(script: str, code: int) -> None:
    process = await asyncio.create_subprocess_exec("sh", "-c", script)
    await wait_or_kill(process, 600 if code > 0 else 0.1)
    assert process.returncode == code


async def test_cancelling_the_wait_for_a_program_kills_it() -> None:
    process = await asyncio.create_subprocess_exec("sleep", "600")
    waiting = asyncio.create_task(wait_or_kill(process, 600))
    await asyncio.sleep(0)
    waiting.cancel()
    with pytest.raises(asyncio.CancelledError):
        await waiting
    assert process.returncode == -9
