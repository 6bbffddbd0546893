"""`board run --board lm3s6965evb` as a process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from msgspec.structs import replace

from loop_watch import FolderWatch
from rostether.bridge.reporter import SilentReporter
from rostether.cli.board.qemu import find_program, measure_program
from rostether.cli.board.simulated_links import simulated
from rostether.errors import BoardError, ConfigError
from rostether.transports.address_parser import parse_address

COMMAND = (sys.executable, "-m", "rostether", "board", "run", "--board", "lm3s6965evb")


SKETCH = "void setup() {}\nvoid loop() {}\n"


def run_to_end(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*COMMAND, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120
    )


@pytest.mark.parametrize("options", ["&watch=D13", "&uart=1", "&seed=2"])
async def test_serve_refuses_options_of_other_boards(options: str) -> None:
    link = parse_address(f"sim:x.elf?board=lm3s6965evb{options}")
    with pytest.raises(ConfigError, match="simulated without pins"):
        async with simulated([link], SilentReporter()):
            pass


async def test_serve_refuses_other_files_than_elf() -> None:
    with pytest.raises(ConfigError, match="runs only ELF files;"):
        async with simulated([parse_address("sim:blink.ino?board=lm3s6965evb")], SilentReporter()):
            pass


def test_other_files_than_elf_are_refused_with_the_next_step() -> None:
    result = run_to_end("blink.ino")
    assert result.returncode == 1
    assert "runs only ELF files; compile blink.ino with arm-none-eabi-g++ first" in result.stderr


def test_options_of_other_boards_are_refused() -> None:
    result = run_to_end("x.elf", "--watch", "D13")
    assert result.returncode == 1
    assert "simulated without pins and devices" in result.stderr


@pytest.mark.qemu
def test_a_program_that_qemu_cannot_run_is_refused(tmp_path: Path) -> None:
    (tmp_path / "nothing.elf").mkdir()
    result = run_to_end(str(tmp_path / "nothing.elf"))
    assert result.returncode == 1
    assert "nothing.elf cannot run on the lm3s6965evb: it is not a complete ELF file" in result.stderr


@pytest.mark.parametrize("name", ["program.elf", "program.HEX"])
async def test_a_program_is_used_without_a_build(name: str, tmp_path: Path) -> None:
    file = tmp_path / name
    file.touch()
    assert await find_program(file, "uno") == file


async def test_a_sketch_that_does_not_exist() -> None:
    with pytest.raises(BoardError, match="none does not exist"):
        await find_program(Path("none"), "uno")


async def test_a_build_lists_no_folder_on_the_event_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def build(sketch: Path, *_: Any) -> Any:
        list(sketch.iterdir())
        return SimpleNamespace(elf=sketch / "sketch.elf")

    monkeypatch.setattr("rostether.firmware.build.build_sketch", build)
    monkeypatch.setattr("rostether.firmware.build.find_board", lambda _: list(tmp_path.iterdir()))
    watch = FolderWatch()
    assert await find_program(tmp_path, "uno") == tmp_path / "sketch.elf"
    assert watch.listed == []


@pytest.mark.simavr
async def test_a_real_build_lists_no_folder_on_the_event_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    sketch = tmp_path / "empty" / "empty.ino"
    sketch.parent.mkdir()
    sketch.write_text(SKETCH)
    watch = FolderWatch()
    program = await find_program(sketch, "uno")
    assert watch.listed == []
    assert program.exists()
    size = measure_program(program, "uno")
    assert size is not None
    assert (size.flash_limit_bytes, size.ram_limit_bytes) == (32256, 2048)
    assert 0 < size.flash_bytes < 2000
    # Without a board of that name, the program's size is known, and the memory is not.
    assert measure_program(program, "none") == replace(size, flash_limit_bytes=0, ram_limit_bytes=0)


def test_other_files_than_elf_have_no_known_size(tmp_path: Path) -> None:
    broken = tmp_path / "broken.elf"
    broken.write_bytes(b"no program")
    assert measure_program(broken, "uno") is None
    assert measure_program(tmp_path / "program.hex", "uno") is None
