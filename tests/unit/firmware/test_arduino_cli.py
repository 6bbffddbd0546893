"""Building with arduino-cli: a fake program records its arguments."""

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import FirmwareError, SketchError
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuildOptions
from unit.firmware.programs import FakeProgram
from unit.firmware.sketches import EMPTY, write_sketch

ESP32 = find_board("esp32:esp32:esp32")
WRITES = (
    "folder = pathlib.Path(arguments[arguments.index('--output-dir') + 1])\n"
    "folder.mkdir(parents=True, exist_ok=True)\n"
    "for each in ('S.ino.elf', 'S.ino.bin', 'S.ino.bootloader.bin', 'S.ino.partitions.bin'):\n"
    "    (folder / each).write_text(each)\n"
)


@pytest.fixture
def arduino_cli(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FakeProgram:
    (tmp_path / "bin").mkdir()
    program = FakeProgram(tmp_path / "bin", "arduino-cli", monkeypatch)
    program.behave(then=WRITES)
    return program


async def test_it_builds_for_boards_of_other_platforms(tmp_path: Path, arduino_cli: FakeProgram) -> None:
    sketch = write_sketch(tmp_path, "S", EMPTY)
    built = await build_sketch(sketch, ESP32)
    (call,) = arduino_cli.calls
    assert call[:3] == ["compile", "--fqbn", "esp32:esp32:esp32"]
    assert call[-3:] == ["--warnings", "none", str(sketch)]
    assert (built.elf.name, built.image.name) == ("S.ino.elf", "S.ino.bin")


async def test_it_gets_the_ros_library(tmp_path: Path, arduino_cli: FakeProgram) -> None:
    text = "#include <ros.h>\n#include <std_msgs/String.h>\n" + EMPTY
    built = await build_sketch(write_sketch(tmp_path, "S", text), ESP32)
    (call,) = arduino_cli.calls
    library = Path(call[call.index("--library") + 1])
    assert (library / "src" / "ros.h").is_file()
    assert (library / "src" / "std_msgs" / "String.h").is_file()
    assert [each.name for each in built.libraries] == ["ros_lib"]


async def test_a_loose_file_gets_the_folder_that_arduino_cli_needs(
    tmp_path: Path, arduino_cli: FakeProgram
) -> None:
    (tmp_path / "S.ino").write_text(EMPTY)
    await build_sketch(tmp_path / "S.ino", ESP32, BuildOptions(defines=("A=1",)))
    (call,) = arduino_cli.calls
    assert (Path(call[-1]) / "S.ino").read_text() == EMPTY
    assert "compiler.cpp.extra_flags=-DA=1" in call


async def test_errors_are_shown_unchanged(
    tmp_path: Path, arduino_cli: FakeProgram, monkeypatch: pytest.MonkeyPatch
) -> None:
    sketch = write_sketch(tmp_path, "S", EMPTY)
    monkeypatch.chdir(tmp_path)
    arduino_cli.behave(code=1, prints=f"{sketch}/S.ino:3:1: error: nonsense")
    with pytest.raises(SketchError) as caught:
        await build_sketch(sketch, ESP32)
    assert "S/S.ino:3:1: error: nonsense" in caught.value.diagnostics


async def test_a_missing_platform_is_reported_with_what_to_type(
    tmp_path: Path, arduino_cli: FakeProgram
) -> None:
    arduino_cli.behave(code=1, prints="Error during build: Platform 'esp32:esp32' not found: not installed")
    with pytest.raises(SketchError, match="run: arduino-cli core install esp32:esp32"):
        await build_sketch(write_sketch(tmp_path, "S", EMPTY), ESP32)


async def test_without_it_a_board_of_another_platform_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FirmwareError, match="building for esp32:esp32:esp32 needs arduino-cli"):
        await build_sketch(write_sketch(tmp_path, "S", EMPTY), ESP32)
