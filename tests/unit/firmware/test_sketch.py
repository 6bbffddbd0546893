from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import FirmwareError
from rostether.firmware.sketch import open_sketch
from unit.firmware.sketches import EMPTY, write_sketch


def test_a_folder_has_its_main_file_first(tmp_path: Path) -> None:
    folder = write_sketch(
        tmp_path,
        "Robot",
        EMPTY,
        {"arm.ino": "", "zoo.ino": "", "a.cpp": "", "src/deep/b.c": "", "notes.txt": ""},
    )
    sketch = open_sketch(folder)
    assert [each.name for each in sketch.inos] == ["Robot.ino", "arm.ino", "zoo.ino"]
    assert [each.name for each in sketch.sources] == ["a.cpp", "b.c"]
    assert sketch.owns_folder


def test_the_main_file_means_its_folder(tmp_path: Path) -> None:
    folder = write_sketch(tmp_path, "Robot", EMPTY, {"arm.ino": ""})
    assert open_sketch(folder / "Robot.ino") == open_sketch(folder)


def test_a_file_among_unrelated_files_is_read_alone(tmp_path: Path) -> None:
    (tmp_path / "blink.ino").write_text(EMPTY)
    (tmp_path / "other.ino").write_text(EMPTY)
    (tmp_path / "other.cpp").write_text("")
    sketch = open_sketch(tmp_path / "blink.ino")
    assert (sketch.inos, sketch.sources) == ((tmp_path / "blink.ino",), ())


def test_a_cpp_file_is_a_sketch(tmp_path: Path) -> None:
    (tmp_path / "main.cpp").write_text("#include <Arduino.h>\n" + EMPTY)
    sketch = open_sketch(tmp_path / "main.cpp")
    assert (sketch.name, sketch.inos, sketch.sources) == ("main", (), (tmp_path / "main.cpp",))


@pytest.mark.parametrize(
    ("files", "name", "message"),
    [
        ((), "nothing.ino", "no sketch .*nothing.ino"),
        (("a.ino", "b.ino"), "", r"contains several sketches \(a.ino, b.ino\); give one"),
        (("readme.txt",), "", "contains no .ino or .cpp file"),
        (("readme.txt",), "readme.txt", "readme.txt is not a sketch"),
    ],
)
def test_other_paths_are_reported(tmp_path: Path, files: tuple[str, ...], name: str, message: str) -> None:
    for each in files:
        (tmp_path / each).write_text("")
    with pytest.raises(FirmwareError, match=message):
        open_sketch(tmp_path / name)
