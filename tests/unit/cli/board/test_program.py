"""What a simulated board is to run, and how it is made while a bridge serves its boards."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from loop_watch import FolderWatch
from rostether.cli.board.program import find_program, measure_program
from rostether.errors import BoardError

SKETCH = "void setup() {}\nvoid loop() {}\n"


@pytest.mark.parametrize("name", ["program.elf", "program.HEX"])
async def test_a_program_is_taken_as_it_is(name: str) -> None:
    assert await find_program(Path(name), "uno") == Path(name)


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
