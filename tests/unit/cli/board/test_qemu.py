"""`board run --board lm3s6965evb` as a process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rostether.bridge.reporter import SilentReporter
from rostether.cli.board.simulated_links import simulated
from rostether.errors import ConfigError
from rostether.transports.address import parse_address

COMMAND = (sys.executable, "-m", "rostether", "board", "run", "--board", "lm3s6965evb")


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


async def test_serve_refuses_what_is_no_elf() -> None:
    with pytest.raises(ConfigError, match="runs only ELF files;"):
        async with simulated([parse_address("sim:blink.ino?board=lm3s6965evb")], SilentReporter()):
            pass


def test_what_is_no_elf_is_refused_with_what_to_do() -> None:
    result = run_to_end("blink.ino")
    assert result.returncode == 1
    assert "runs only ELF files; compile blink.ino with arm-none-eabi-g++ first" in result.stderr


def test_options_of_other_boards_are_refused() -> None:
    result = run_to_end("x.elf", "--watch", "D13")
    assert result.returncode == 1
    assert "simulated without pins and devices" in result.stderr


@pytest.mark.qemu
def test_what_qemu_cannot_run_ends_with_what_it_says(tmp_path: Path) -> None:
    result = run_to_end(str(tmp_path / "nothing.elf"))
    assert result.returncode == 1
    assert "rostether: error: qemu has ended: " in result.stderr
    assert "nothing.elf" in result.stderr
