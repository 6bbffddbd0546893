"""The debugging information of each DWARF version that compilers write."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from rostether.firmware.elf import ElfFile, Variable

pytestmark = pytest.mark.arm

PROGRAM = """
namespace robot { struct Wheel { int ticks; }; }
robot::Wheel left = {3};
extern "C" int _start() { static const int step = 2; return left.ticks += *(volatile const int*)&step; }
"""


def build(folder: Path, version: int) -> ElfFile:
    source = folder / "wheel.cpp"
    source.write_text(PROGRAM)
    options = [f"-gdwarf-{version}", "-O1", "-nostdlib", "-mcpu=cortex-m3", "-mthumb"]
    program = folder / f"wheel{version}.elf"
    subprocess.run(["arm-none-eabi-g++", *options, source, "-o", program], check=True)
    return ElfFile.read(program)


@pytest.mark.parametrize("version", [2, 3, 4, 5])
def test_every_version_lists_files_and_types(tmp_path: Path, version: int) -> None:
    elf = build(tmp_path, version)
    source = str(tmp_path / "wheel.cpp")
    left = next(each.address for each in elf.symbols if each.name == "left")
    assert Variable("left", left, "robot::Wheel", source) in elf.variables
    assert {each.file for each in elf.code_ranges} == {source}
