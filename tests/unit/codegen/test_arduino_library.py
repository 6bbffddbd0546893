"""The whole library; its metadata follows the documented rules of arduino-lint."""

from __future__ import annotations

import json
import re
import time
import tomllib
from pathlib import Path

import pytest

from rostether.codegen.arduino_library import (
    RenderedLibrary,
    keywords_with_classes,
    render_library,
    write_library,
)
from rostether.codegen.library_source import client_library, library_files
from rostether.errors import CodegenError
from rostether.msgdef.registry import Registry
from unit.codegen.hostile import write_definitions

REPOSITORY = Path(__file__).parents[3]
HEADER_SUFFIXES = (".h", ".hpp", ".hh")
CATEGORIES = {
    *("Display", "Communication", "Signal Input/Output", "Sensors", "Device Control", "Timing"),
    *("Data Storage", "Data Processing", "Other"),
}


@pytest.fixture(scope="module")
def library() -> RenderedLibrary:
    return render_library(Registry())


def properties(library: RenderedLibrary) -> dict[str, str]:
    lines = library.files["library.properties"].decode().splitlines()
    return dict(line.split("=", 1) for line in lines if line and not line.startswith("#"))


def test_all_types_have_a_header(library: RenderedLibrary) -> None:
    assert len(library.types) > 150
    assert {f"src/{name}.h" for name in library.types} <= set(library.files)
    assert (library.skipped, library.warnings) == ((), ())


def test_the_hand_written_files_are_unchanged(library: RenderedLibrary) -> None:
    source = client_library()
    for path in library_files(source):
        if path != "keywords.txt":
            assert library.files[path] == (source / path).read_bytes()


def test_the_same_definitions_give_the_same_bytes(library: RenderedLibrary) -> None:
    again = render_library(Registry())
    assert list(again.files.items()) == list(library.files.items())
    year = re.compile(rb"20[2-9][0-9]-")
    assert not any(
        year.search(text) for path, text in library.files.items() if path.startswith("src/std_msgs/")
    )


def test_everything_takes_less_than_a_second() -> None:
    started = time.process_time()
    render_library(Registry())
    assert time.process_time() - started < 1


def test_a_library_for_a_sketch_is_small(tmp_path: Path) -> None:
    (tmp_path / "blink.ino").write_text("#include <ros.h>\n#include <std_msgs/Empty.h>\n")
    library = render_library(Registry(), for_sketch=tmp_path / "blink.ino")
    assert "std_msgs/Empty" in library.types
    assert len(library.types) < 12
    assert not any(path.startswith(("examples/", "extras/")) for path in library.files)


def test_a_sketch_and_packages_add_up(tmp_path: Path) -> None:
    (tmp_path / "blink.ino").write_text("#include <std_msgs/Empty.h>\n")
    library = render_library(Registry(), for_sketch=tmp_path / "blink.ino", packages=["std_srvs"])
    assert {"std_msgs/Empty", "std_srvs/Trigger"} <= set(library.types)


def test_it_is_written_and_replaced(tmp_path: Path) -> None:
    first = write_library(tmp_path, Registry(), packages=["std_msgs"])
    assert (first.path, first.replaced) == (tmp_path / "ros_lib", False)
    second = write_library(tmp_path, Registry(), packages=["std_srvs"])
    assert second.replaced
    assert not (tmp_path / "ros_lib" / "src" / "std_msgs" / "Float32.h").exists()
    with pytest.raises(CodegenError, match="is a library itself; give the folder that contains it"):
        write_library(tmp_path / "ros_lib", Registry())


def test_the_hand_written_library_is_never_replaced(tmp_path: Path) -> None:
    (tmp_path / "ros_lib").symlink_to(client_library())
    with pytest.raises(CodegenError, match="is the hand-written library itself"):
        write_library(tmp_path, Registry(), packages=["std_msgs"])


def test_skipped_types_do_not_stop_the_others(tmp_path: Path) -> None:
    definitions = {"mine/msg/Good.msg": "uint8 x\n", "mine/msg/Bad.msg": "uint8\n"}
    library = render_library(Registry([write_definitions(tmp_path, definitions)]))
    assert "mine/Good" in library.types
    assert len(library.skipped) == 1
    assert f"skipped mine/Bad: {tmp_path}/mine/msg/Bad.msg:1:1: " in library.skipped[0]


def test_metadata_follows_the_rules_of_arduino_lint(library: RenderedLibrary) -> None:
    of = properties(library)
    assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_.-]{0,15}", of["name"])
    assert not re.search("arduino|library", of["name"], re.IGNORECASE)
    # If several libraries have a header, the Arduino IDE prefers the library with the header's name.
    assert f"src/{of['name']}.h" in library.files
    assert re.fullmatch(r"\d+\.\d+\.\d+", of["version"])
    assert of["author"] and of["maintainer"] and not of["maintainer"].lower().startswith("arduino")
    assert of["sentence"] and of["paragraph"] and of["sentence"] not in of["paragraph"]
    assert of["category"] in CATEGORIES
    assert of["url"].startswith("https://")
    assert of["architectures"] == "*"
    assert all(f"src/{header}" in library.files for header in of["includes"].split(","))
    assert set(of) == {
        *("name", "version", "author", "maintainer", "sentence", "paragraph"),
        *("category", "url", "architectures", "includes"),
    }
    assert {"README.md", "LICENSE"} <= set(library.files)
    assert not any(path.endswith(".exe") or path.startswith("src/utility/") for path in library.files)
    headers_in_root = [path for path in library.files if "/" not in path and path.endswith(HEADER_SUFFIXES)]
    assert headers_in_root == []


def test_keywords_are_words_and_kinds_with_a_tab_between(library: RenderedLibrary) -> None:
    lines = library.files["keywords.txt"].decode().splitlines()
    rows = [line.split("\t") for line in lines if line and not line.startswith("#")]
    assert all(len(row) == 2 and row[1] in ("KEYWORD1", "KEYWORD2", "LITERAL1") for row in rows)
    words = [row[0] for row in rows]
    assert len(words) == len(set(words))
    assert {"NodeHandle", "advertise", "String", "Imu", "SetBool"} <= set(words)


def test_platformio_and_python_have_the_same_version(library: RenderedLibrary) -> None:
    described = json.loads(library.files["library.json"])
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    assert described["name"] == properties(library)["name"]
    assert described["version"] == properties(library)["version"] == project["version"]
    assert [f"src/{header}" in library.files for header in described["headers"]] == [True]


def test_no_file_names_differ_only_in_case(library: RenderedLibrary) -> None:
    assert len({path.casefold() for path in library.files}) == len(library.files)


def test_classes_are_added_to_the_keywords_once_and_sorted() -> None:
    library = "# words\nNodeHandle\tKEYWORD1\nString\tKEYWORD1\nadvertise\tKEYWORD2\n"
    assert keywords_with_classes(library, ["String", "Range", "Imu", "Imu"]) == (
        f"{library}Imu\tKEYWORD1\nRange\tKEYWORD1\n"
    )
