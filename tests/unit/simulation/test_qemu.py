from __future__ import annotations

import os
import shutil
import struct
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rostether.errors import BoardError, TransportOpenError
from rostether.simulation.qemu import QemuBoard, is_arm_program

# The numbers of machines in the header of an ELF file.
ARM, AVR = 40, 83

pytestmark = pytest.mark.qemu


@pytest.fixture
def endless_loop(tmp_path: Path) -> Path:
    """A Cortex-M program in an ELF file: stack, start, and a jump to itself."""
    code = struct.pack("<II", 0x20010000, 0x9) + b"\xfe\xe7" * 4
    kind = b"\x7fELF\x01\x01\x01" + bytes(9)
    header = struct.pack("<HHIIIIIHHHHHH", 2, ARM, 1, 8, 52, 0, 0x5000200, 52, 32, 1, 0, 0, 0)
    segment = struct.pack("<8I", 1, 84, 0, 0, len(code), len(code), 5, 4)
    program = tmp_path / "loop.elf"
    program.write_bytes(kind + header + segment + code)
    return program


async def test_it_runs_and_can_be_reset_and_ended(endless_loop: Path, tmp_path: Path) -> None:
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


async def test_qemu_refuses_an_unknown_machine(endless_loop: Path) -> None:
    with pytest.raises(BoardError, match="unsupported machine type"):
        await QemuBoard.start(endless_loop, machine="lm3s0")


@pytest.mark.parametrize(
    ("start", "size"),
    [(b"\x7fELF", 51), (b"\x7fELF", 83), (b"\x7fELF", 99), (b"noise", 100)],
    ids=["no header", "no segment table", "no end", "not an ELF file"],
)
def test_only_complete_elf_files_are_run(endless_loop: Path, start: bytes, size: int) -> None:
    whole = endless_loop.read_bytes()
    assert is_arm_program(endless_loop)
    endless_loop.write_bytes((start + whole[len(start) :])[:size])
    assert not is_arm_program(endless_loop)


async def test_a_program_for_another_processor(endless_loop: Path) -> None:
    content = bytearray(endless_loop.read_bytes())
    content[18] = AVR
    endless_loop.write_bytes(content)
    with pytest.raises(BoardError, match="cannot run on the lm3s6965evb"):
        await QemuBoard.start(endless_loop)


async def test_ctrl_c_in_the_terminal_does_not_reach_it(endless_loop: Path) -> None:
    async with await QemuBoard.start(endless_loop) as board:
        assert os.getpgid(board._process.pid) != os.getpgrp()


async def test_another_file_at_the_link_is_not_changed(endless_loop: Path, tmp_path: Path) -> None:
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
    # There may be no process to reap it.
    while status.exists() and "zombie" not in status.read_text():
        assert time.monotonic() < deadline
        time.sleep(0.01)
