from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.firmware.libraries import (
    SIMULATION_LIBRARIES,
    Origin,
    choose,
    read_folder,
    read_given,
    read_library,
    sketchbook_folders,
)


def write(folder: Path, *files: str) -> Path:
    for each in files:
        path = folder / each
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("architectures=avr\n" if path.suffix == ".properties" else "")
    return folder


def test_a_library_with_src_is_compiled_recursively(tmp_path: Path) -> None:
    folder = write(
        tmp_path / "Enc",
        "library.properties",
        "src/Enc.h",
        "src/Enc.cpp",
        "src/in/deep.c",
        "examples/x/x.cpp",
    )
    library = read_library(folder, Origin.GIVEN)
    assert library.include_folders == (folder / "src",)
    assert [each.name for each in library.sources()] == ["Enc.cpp", "deep.c"]


def test_a_flat_library_is_compiled_from_its_root_and_utility(tmp_path: Path) -> None:
    folder = write(tmp_path / "Enc", "Enc.h", "Enc.cpp", "utility/u.cpp", "tests/t.cpp")
    library = read_library(folder, Origin.GIVEN)
    assert library.include_folders == (folder, folder / "utility")
    assert [each.name for each in library.sources()] == ["Enc.cpp", "u.cpp"]


def test_a_given_folder_is_a_library_or_contains_libraries(tmp_path: Path) -> None:
    write(tmp_path / "libs" / "A", "A.h")
    write(tmp_path / "libs" / "B", "library.properties", "src/B.h")
    assert [each.name for each in read_given(tmp_path / "libs")] == ["A", "B"]
    assert [each.name for each in read_given(tmp_path / "libs" / "A")] == ["A"]
    assert read_given(tmp_path / "libs" / "B")[0].provides("B.h")


def test_a_given_folder_without_libraries_is_reported(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no such folder"):
        read_given(tmp_path / "nowhere")
    with pytest.raises(ConfigError, match="contains no headers; give the folder of a library"):
        read_given(tmp_path)


def test_given_libraries_have_priority(tmp_path: Path) -> None:
    given = read_library(write(tmp_path / "a" / "My", "Servo.h"), Origin.GIVEN)
    own = read_library(write(tmp_path / "b" / "Servo", "Servo.h"), Origin.SKETCHBOOK)
    ours = read_folder(SIMULATION_LIBRARIES, Origin.SIMULATION)
    assert choose("Servo.h", [*ours, own, given]) == given
    assert choose("Servo.h", [*ours, own]) == own
    assert choose("Servo.h", ours) is not None
    assert choose("Nothing.h", ours) is None


def test_the_name_and_the_architecture_choose_among_several(tmp_path: Path) -> None:
    other = write(tmp_path / "Motor", "Motor.h", "library.properties")
    (other / "library.properties").write_text("architectures=esp32\n")
    write(tmp_path / "AMotorThing", "Motor.h")
    write(tmp_path / "MotorPlus", "Motor.h")
    libraries = read_folder(tmp_path, Origin.SKETCHBOOK)
    chosen = choose("Motor.h", libraries)
    assert chosen is not None
    assert chosen.name == "MotorPlus"


def test_the_sketchbook_is_that_of_the_ide(tmp_path: Path) -> None:
    assert sketchbook_folders({}, tmp_path)[0] == tmp_path / "Arduino" / "libraries"
    assert sketchbook_folders({"ARDUINO_DIRECTORIES_USER": "/s"}, tmp_path) == [Path("/s/libraries")]


def test_built_in_libraries_keep_their_names() -> None:
    names = [each.name for each in read_folder(SIMULATION_LIBRARIES, Origin.SIMULATION)]
    assert names == ["Ethernet", "Servo"]
