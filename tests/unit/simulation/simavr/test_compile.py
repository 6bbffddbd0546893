from __future__ import annotations

import asyncio
import os
import stat
from collections.abc import Sequence
from pathlib import Path

import pytest

from rostether.errors import BoardError
from rostether.simulation.simavr import compile as compiling
from rostether.simulation.simavr.compile import PACKAGES, SOURCES, build_runner

LONGEST_FILE_LINES = 330


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "rostether" / "simavr"


@pytest.mark.simavr
async def test_it_is_compiled_once_by_several_processes_without_a_warning(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands: list[str] = []

    async def run(command: Sequence[str], limit: asyncio.Semaphore) -> None:
        commands.append(command[-1])
        await _run(command, limit)

    _run = compiling._run
    monkeypatch.setattr(compiling, "_run", run)
    monkeypatch.setattr(compiling, "FLAGS", (*compiling.FLAGS, "-Werror"))
    programs = await asyncio.gather(build_runner(), build_runner())
    assert programs[0] == programs[1]
    assert [path.name for path in cache.iterdir()] == [programs[0].name]
    assert os.access(programs[0], os.X_OK)
    assert await build_runner() == programs[0]
    assert len(commands) == len(list(SOURCES.glob("*.c"))) + 1


async def test_missing_parts_are_reported_with_their_packages(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, cache: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    with pytest.raises(BoardError, match=f"no C compiler is installed.*sudo apt install {PACKAGES}"):
        await build_runner()


@pytest.mark.parametrize(
    ("printed", "reported"),
    [
        ("core.c:5: fatal error: sim_avr.h: No such file or directory", "libsimavr is not installed"),
        ("firmware.c:3: fatal error: gelf.h: No such file or directory", "libelf is not installed"),
        ("/usr/bin/ld: cannot find -lsimavr", "libsimavr is not installed"),
        ("/usr/bin/ld: cannot find -lelf", "libelf is not installed"),
        ("main.c:1: error: something else", "does not compile with .*: main.c:1: error: something else"),
    ],
)
async def test_a_failing_compiler_is_explained_in_one_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, cache: Path, printed: str, reported: str
) -> None:
    compiler = tmp_path / "broken-cc"
    compiler.write_text(f"#!/bin/sh\necho '{printed}' >&2\nexit 1\n")
    compiler.chmod(stat.S_IRWXU)
    monkeypatch.setenv("CC", str(compiler))
    with pytest.raises(BoardError, match=reported) as raised:
        await build_runner()
    assert "\n" not in str(raised.value)
    assert list(cache.iterdir()) == []


async def test_a_cache_that_cannot_be_written_is_reported(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    monkeypatch.setenv("CC", "true")
    with pytest.raises(BoardError, match="set XDG_CACHE_HOME"):
        await build_runner()


def test_one_concept_a_file_in_c_too() -> None:
    lengths = {path.name: len(path.read_text().splitlines()) for path in SOURCES.iterdir()}
    assert {name: length for name, length in lengths.items() if length > LONGEST_FILE_LINES} == {}
    assert all("GPL-3.0-or-later" in path.read_text() for path in SOURCES.iterdir())
