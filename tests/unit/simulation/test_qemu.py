from __future__ import annotations

import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rostether.errors import BoardError, TransportOpenError
from rostether.simulation.qemu import QemuBoard

pytestmark = pytest.mark.qemu


@pytest.fixture
def endless_loop(tmp_path: Path) -> Path:
    """A Cortex-M program, as bare bytes: stack, start, and a jump to itself."""
    program = tmp_path / "loop.bin"
    program.write_bytes((0x20010000).to_bytes(4, "little") + (0x9).to_bytes(4, "little") + b"\xfe\xe7" * 4)
    return program


async def test_it_runs_is_linked_is_reset_and_ends(endless_loop: Path, tmp_path: Path) -> None:
    link = tmp_path / "board"
    async with await QemuBoard.start(endless_loop, link_path=link) as board:
        assert str(link.readlink()) == board.address
        assert Path(board.address).is_char_device()
        await board.reset()
        assert not board.has_ended
    assert board.has_ended
    assert not link.is_symlink()
    with pytest.raises(BoardError, match="has ended"):
        await board.reset()


async def test_an_unknown_machine_is_qemus_to_refuse(endless_loop: Path) -> None:
    with pytest.raises(BoardError, match="unsupported machine type"):
        await QemuBoard.start(endless_loop, machine="lm3s0")


async def test_a_program_that_is_not_there(tmp_path: Path) -> None:
    async with await QemuBoard.start(tmp_path / "nothing.elf") as board:
        await board.wait_end()
    assert "nothing.elf" in board.last_words


async def test_something_else_at_the_link_is_not_touched(endless_loop: Path, tmp_path: Path) -> None:
    link = tmp_path / "precious"
    link.write_text("mine")
    with pytest.raises(TransportOpenError):
        await QemuBoard.start(endless_loop, link_path=link)
    assert link.read_text() == "mine"


async def test_without_qemu(endless_loop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(BoardError, match="apt install qemu-system-arm"):
        await QemuBoard.start(endless_loop)


@pytest.mark.skipif(shutil.which("setpriv") is None, reason="no setpriv")
def test_it_ends_with_a_parent_that_is_killed(endless_loop: Path) -> None:
    script = (
        "import asyncio, sys\nfrom pathlib import Path\nfrom rostether.simulation.qemu import QemuBoard\n"
        "async def main():\n"
        "    board = await QemuBoard.start(Path(sys.argv[1]))\n"
        "    print(board._process.pid, flush=True)\n"
        "    await asyncio.sleep(60)\n"
        "asyncio.run(main())\n"
    )
    with subprocess.Popen([sys.executable, "-c", script, endless_loop], stdout=subprocess.PIPE) as parent:
        assert parent.stdout is not None
        status = Path(f"/proc/{int(parent.stdout.readline())}/status")
        assert "qemu" in status.read_text()
        parent.kill()
    deadline = time.monotonic() + 60
    # Nobody may be there to reap it.
    while status.exists() and "zombie" not in status.read_text():
        assert time.monotonic() < deadline
        time.sleep(0.01)
