from __future__ import annotations

import re
import resource
import struct
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from rostether.errors import FirmwareError
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuiltFirmware
from rostether.firmware.demangle import shorten
from rostether.firmware.elf import ElfFile
from rostether.firmware.footprint import MARGIN_BYTES, Footprint, measure, measure_built
from rostether.firmware.origins import MESSAGES, NODE, SKETCH, Origins
from unit.firmware.sketches import uno, write_sketch
from unit.firmware.test_build import HELLO

pytestmark = pytest.mark.avr

SERIAL = """
volatile int used[50] = {1, 2};
void setup() { Serial.begin(9600); }
void loop() { Serial.println(used[3]); }
"""


async def build(tmp_path: Path, text: str, board: str = "uno") -> BuiltFirmware:
    return await build_sketch(write_sketch(tmp_path, "S", text), find_board(board))


def group(footprint: Footprint, name: str) -> tuple[int, int]:
    return next(
        ((each.flash_bytes, each.ram_bytes) for each in footprint.groups if each.name == name), (0, 0)
    )


@pytest.mark.parametrize("board", ["uno", "mega", "leonardo"])
@pytest.mark.parametrize("text", [SERIAL, HELLO], ids=["serial", "ros"])
async def test_the_groups_add_up_to_the_total_of_avr_size(tmp_path: Path, text: str, board: str) -> None:
    built = await build(tmp_path, text, board)
    footprint = await measure_built(built)
    output = subprocess.run(["avr-size", built.elf], check=True, capture_output=True, text=True).stdout
    code, data, bss = map(int, re.findall(r"\d+", output.splitlines()[1])[:3])
    assert footprint.flash_bytes == code + data == sum(each.flash_bytes for each in footprint.groups)
    assert footprint.ram_bytes == data + bss == sum(each.ram_bytes for each in footprint.groups)
    for each in footprint.groups:
        assert each.flash_bytes >= sum(item.flash_bytes for item in each.largest), each
        assert each.ram_bytes >= sum(item.ram_bytes for item in each.largest), each


async def test_everything_belongs_to_a_group(tmp_path: Path) -> None:
    text = "#include <Wire.h>\n#include <Servo.h>\nServo s;\n" + HELLO.replace(
        "nh.initNode();", "nh.initNode(); Wire.begin(); s.attach(9); s.write(20);"
    )
    footprint = await measure_built(await build(tmp_path, text))
    for name in ("ROS node", "Serial", "Arduino core", "Wire", "Servo", "C library and arithmetic"):
        assert group(footprint, name)[0] > 50, name
    assert group(footprint, "Servo")[1] >= 60
    assert group(footprint, "ROS node")[1] > 280
    assert group(footprint, "Serial")[1] >= 157
    assert group(footprint, "messages")[0] > 30
    assert group(footprint, "your sketch")[0] > 30
    # A variable of Servo in an unnamed namespace: the linker adds a number to its name.
    assert "channels" in {item.name for each in footprint.groups for item in each.largest}


def test_a_sketch_below_the_ros_library_is_the_user_s() -> None:
    folder = Path("/book/libraries/ros_lib/examples/Blink")
    origins = Origins(folder)
    library, own_library = folder.parents[1] / "src", folder / "ros_lib"
    assert origins.of_file(f"{folder}/Blink.ino") == origins.of_file(f"{folder}/blinker.h") == SKETCH
    assert origins.of_file(f"{library}/ros/node_handle.h") == NODE
    assert origins.of_file(f"{own_library}/ros/node_handle.h") == NODE
    assert origins.of_file(f"{own_library}/std_msgs/Empty.h") == MESSAGES


def test_shortened_names_have_no_unnamed_namespaces() -> None:
    assert shorten("void (anonymous namespace)::turn<int>(int)") == "turn<int>()"
    assert shorten("Servo::(anonymous namespace)::channels") == "Servo::channels"


def test_shortened_names_have_no_types_of_results() -> None:
    assert shorten("unsigned char* A<B, (C)1>::f<int, D<E> >(int, F const&)") == "A<B, (C)1>::f<int, D<E> >()"
    assert shorten("guard variable for f()::x") == "guard variable for f()"


async def test_variables_and_functions_are_named(tmp_path: Path) -> None:
    footprint = await measure_built(await build(tmp_path, SERIAL))
    items = {item.name: item for each in footprint.groups for item in each.largest}
    assert (items["used"].flash_bytes, items["used"].ram_bytes, items["used"].group) == (
        100,
        100,
        "your sketch",
    )
    assert items["Serial"].group == "Serial"


async def test_an_elf_file_alone_can_be_measured(tmp_path: Path) -> None:
    built = await build(tmp_path, SERIAL)
    footprint = await measure(built.elf, uno())
    assert footprint.fits
    assert group(footprint, "Serial")[1] >= 157


async def test_a_program_that_does_not_fit_is_refused_with_its_largest_part(tmp_path: Path) -> None:
    small = replace(uno(), flash_bytes=1000, ram_bytes=200)
    footprint = await measure((await build(tmp_path, SERIAL)).elf, small)
    assert not footprint.fits
    flash, ram = footprint.refusals()
    assert re.match(
        r"\d+ bytes of flash do not fit: Arduino UNO has 1000 for programs, \d+ fewer; the largest is", flash
    )
    assert re.match(r"variables of \d+ bytes do not fit in the 200 bytes of RAM", ram)
    assert "the largest is Serial of Serial (157 bytes)" in ram


async def test_a_stack_that_may_not_fit_is_a_warning(tmp_path: Path) -> None:
    built = await build(tmp_path, SERIAL)
    roomy = await measure(built.elf, uno())
    assert roomy.warnings() == []
    assert roomy.stack is not None
    needed = roomy.ram_bytes + roomy.stack.total_bytes + MARGIN_BYTES
    just = await measure(built.elf, replace(uno(), ram_bytes=needed))
    assert just.warnings() == []
    tight = await measure(built.elf, replace(uno(), ram_bytes=needed - 1))
    assert tight.fits
    assert re.match(r"variables \(\d+ bytes\) and stack \(up to \d+\) leave 63 of", tight.warnings()[0])


@pytest.mark.parametrize("content", [b"", b"\x7fELF\x01\x01", b"\x7fELF\x02\x01" + bytes(100), b":100000"])
async def test_another_file_than_elf_is_reported(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.elf"
    path.write_bytes(content)
    with pytest.raises(FirmwareError, match="ELF file"):
        await measure(path, uno())


async def test_a_damaged_elf_file_raises_only_firmware_errors(tmp_path: Path) -> None:
    built = await build(tmp_path, SERIAL)
    whole = built.elf.read_bytes()
    for cut in range(20, len(whole), len(whole) // 12):
        broken = tmp_path / "broken.elf"
        broken.write_bytes(whole[:cut] + bytes(reversed(whole[cut:])))
        try:
            await measure(broken, uno())
        except FirmwareError as error:
            assert "ELF" in str(error)


async def test_the_size_of_a_damaged_symbol_needs_no_memory(tmp_path: Path) -> None:
    built = await build(tmp_path, SERIAL)
    table = next(each for each in ElfFile.read(built.elf).symbols if each.name.startswith("_ZTV"))
    whole, broken = built.elf.read_bytes(), tmp_path / "broken.elf"
    entry = struct.pack("<II", table.address, table.size)
    assert entry in whole
    broken.write_bytes(whole.replace(entry, struct.pack("<II", table.address, 1 << 31)))
    ended = subprocess.run(
        [sys.executable, "-m", "rostether", "firmware", "size", str(broken)],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30)),
        capture_output=True,
        text=True,
    )
    assert (ended.returncode, ended.stderr) == (0, "")


async def test_without_debugging_information_names_are_used(tmp_path: Path) -> None:
    built = await build(tmp_path, SERIAL)
    stripped = tmp_path / "stripped.elf"
    subprocess.run(["avr-objcopy", "--strip-debug", built.elf, stripped], check=True)
    footprint = await measure(stripped, uno())
    assert footprint.flash_bytes == ElfFile.read(built.elf).flash_bytes
    assert group(footprint, "Serial")[1] >= 157
