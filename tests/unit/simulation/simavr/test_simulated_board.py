from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from rostether.errors import BoardError, ConfigError, TransportOpenError
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from unit.simulation.simavr.conftest import Start
from unit.simulation.simavr.programs import build, build_text
from unit.simulation.simavr.readings import named

pytestmark = pytest.mark.simavr


BLINK = """
void setup() { pinMode(13, OUTPUT); }
void loop() { digitalWrite(13, HIGH); delay(1); digitalWrite(13, LOW); delay(1); }
"""


def open_descriptors() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


async def pid_of(board: SimulatedBoard) -> int:
    return board._process._process.pid


async def test_no_file_or_process_stays(tmp_path: Path) -> None:
    link = tmp_path / "board"
    async with await SimulatedBoard.start(build("echo"), link_path=link):
        pass
    before = open_descriptors()
    for _ in range(5):
        async with await SimulatedBoard.start(build("echo"), link_path=link) as board:
            pid = await pid_of(board)
            assert link.is_symlink()
            assert is_alive(pid)
        assert not is_alive(pid)
        assert not link.is_symlink()
    assert open_descriptors() == before


async def test_it_ends_with_its_parent(tmp_path: Path) -> None:
    parent = textwrap.dedent(
        """
        import asyncio, sys
        from pathlib import Path
        from rostether.simulation.simavr.simulated_board import SimulatedBoard

        async def main():
            board = await SimulatedBoard.start(Path(sys.argv[1]))
            print(board._process._process.pid, flush=True)
            await asyncio.sleep(60)

        asyncio.run(main())
        """
    )
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-c", parent, str(build("echo")), stdout=asyncio.subprocess.PIPE
    )
    assert process.stdout is not None
    pid = int(await process.stdout.readline())
    assert is_alive(pid)
    process.send_signal(signal.SIGKILL)
    await process.wait()
    while is_alive(pid):
        await asyncio.sleep(0.01)


async def test_a_killed_board_is_reported(start: Start) -> None:
    board = await start(build("echo"))
    waiting = asyncio.create_task(board.wait_for("pin"))
    await asyncio.sleep(0)
    os.kill(await pid_of(board), signal.SIGKILL)
    with pytest.raises(BoardError, match="has ended"):
        await waiting
    with pytest.raises(BoardError, match="has ended"):
        await board.reset()
    assert board.has_ended
    assert not board.has_ended_as_requested


async def test_signals_to_the_process_group_do_not_end_it(start: Start) -> None:
    board = await start(build("echo"))
    for sign in (signal.SIGINT, signal.SIGTERM):
        os.kill(await pid_of(board), sign)
    await board.reset()
    assert not board.has_ended


async def test_quit_ends_it(start: Start) -> None:
    board = await start(build("echo"))
    events = [event async for event in board.events()] if await _quits(board) else []
    assert events == []
    assert board.has_ended_as_requested


async def _quits(board: SimulatedBoard) -> bool:
    await board.send_command("quit")
    return True


async def test_events_are_yielded_in_their_order(start: Start, tmp_path: Path) -> None:
    board = await start(await build_text(tmp_path, BLINK), "watch D13", realtime=True, paused=False)
    seen = []
    async for event in board.events():
        seen.append(event["level"])
        if len(seen) == 4:
            break
    assert seen in ([0, 1, 0, 1], [1, 0, 1, 0])
    await board.wait_for_pin("D13", True)
    await board.wait_for_pin("D13", False)


async def test_real_time_is_kept() -> None:
    async with await SimulatedBoard.start(build("echo")) as board:
        loop = asyncio.get_running_loop()
        await board.cycles()
        begun_s, begun = loop.time(), await board.cycles()
        ran_s = 0.0
        async with asyncio.timeout(60):
            # A busy machine may delay the board.
            while ran_s < 0.3:
                await asyncio.sleep(0.05)
                ran_s = (await board.cycles() - begun) / 16e6
        behind = [event["lost_ms"] for event in named(board, "behind")]
        assert ran_s <= loop.time() - begun_s + 0.02 or behind


async def test_each_pause_of_the_simulator_is_reported() -> None:
    async with await SimulatedBoard.start(build("echo")) as board:
        pid = await pid_of(board)
        for _ in range(2):
            paused = asyncio.Event()
            board.pauses.on_pause = paused.set
            os.kill(pid, signal.SIGSTOP)
            await asyncio.sleep(0.4)
            os.kill(pid, signal.SIGCONT)
            await asyncio.wait_for(paused.wait(), 10)


async def test_a_busy_board_uses_little_of_the_processor(tmp_path: Path) -> None:
    async with await SimulatedBoard.start(build("echo")) as board:
        await asyncio.sleep(0.05)
        pid, begun = await pid_of(board), await board.cycles()
        used = _processor_ticks(pid)
        await asyncio.sleep(0.6)
        share = (_processor_ticks(pid) - used) / os.sysconf("SC_CLK_TCK")
        ran_s = (await board.cycles() - begun) / 16e6
        # The runner needs about a tenth of a core. A loop that never sleeps would need a whole core.
        assert share < 0.6 * ran_s


def _processor_ticks(pid: int) -> int:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return int(fields[11]) + int(fields[12])


async def test_a_thousand_commands_at_once(start: Start) -> None:
    board = await start(build("echo"))
    await asyncio.gather(*(board.set_adc("A0", index / 1000) for index in range(1000)))


async def test_commands_are_one_line(start: Start) -> None:
    board = await start(build("echo"))
    with pytest.raises(BoardError, match="one line"):
        await board.send_command("reset\nquit")
    with pytest.raises(BoardError, match="too many words"):
        await board.send_command("watch " + "D1 " * 20)
    await board.send_command("")
    with pytest.raises(BoardError, match="no such command"):
        await board.send_command("x" * 100_000)
    await board.reset()


async def test_invalid_commands_at_the_start(start: Start) -> None:
    with pytest.raises(BoardError, match="watch D77: this board has no such pin"):
        await start(build("echo"), "watch D77")


@pytest.mark.parametrize(
    ("content", "reported"),
    [
        (b"", "it is empty"),
        (b"\x7fELF", "not an ELF file"),
        (b"\x7fELF" + bytes(400), "it is no"),
        (b":00000001FF\n", "contains no program"),
        (b":0400000000000000FD\n:00000001FF\n", "neither an ELF file nor"),
        (b":020000040001F9\n:04FFFE0000000000FF\n", "larger than the board's flash"),
        (b"hello", "neither an ELF file nor"),
        (Path("/bin/sh").read_bytes()[:5000], "not a program for an AVR"),
    ],
    ids=["empty", "magic", "zeros", "end", "checksum", "far", "text", "sh"],
)
async def test_files_that_are_not_programs(
    start: Start, tmp_path: Path, content: bytes, reported: str
) -> None:
    path = tmp_path / "program"
    path.write_bytes(content)
    with pytest.raises(BoardError, match=reported):
        await start(path)


async def test_programs_for_other_boards(start: Start, tmp_path: Path) -> None:
    with pytest.raises(BoardError, match="built for another chip"):
        await start(build("echo", board="mega"))
    with pytest.raises(BoardError, match="cannot be read"):
        await start(tmp_path / "missing.elf")
    with pytest.raises(ConfigError, match="known: uno, nano, promini, mega, leonardo, micro"):
        await start(build("echo"), board="due")


async def test_hex_files_run(start: Start, tmp_path: Path) -> None:
    image = tmp_path / "echo.hex"
    subprocess.run(["avr-objcopy", "-O", "ihex", str(build("echo")), str(image)], check=True)
    board = await start(image, "watch serial")
    await board.run("1ms")
    await board.send(b"as hex")
    await board.run("5ms")
    assert board.serial == b"as hex"
    with pytest.raises(BoardError, match="no symbols"):
        await board.free_stack_bytes()


async def test_a_link_path_in_use_is_not_changed(tmp_path: Path) -> None:
    path = tmp_path / "board"
    path.write_text("mine")
    with pytest.raises(TransportOpenError, match="already exists"):
        await SimulatedBoard.start(build("echo"), link_path=path)
    assert path.read_text() == "mine"
