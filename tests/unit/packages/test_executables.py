from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.packages.executables import find_program, is_python, programs, shebang


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    folder = tmp_path / "ws" / "src" / "arm"
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>arm</name></package>")
    return folder


def write(file: Path, text: str = "#!/usr/bin/env python3\n", *, executable: bool = True) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    file.chmod(0o755 if executable else 0o644)
    return file


def find(folder: Path | None, name: str, **environ: str) -> Path:
    return find_program("arm", name, folder, environ)


def test_a_script_is_found_anywhere_in_its_package(arm: Path) -> None:
    script = write(arm / "src" / "nodes" / "move.py")
    assert find(arm, "move.py") == script


def test_built_programs_have_priority_over_the_source(arm: Path) -> None:
    write(arm / "scripts" / "move.py")
    relay = write(arm.parents[1] / "devel" / "lib" / "arm" / "move.py")
    assert find(arm, "move.py") == relay


def test_installed_programs_are_found_in_the_prefix_path_and_next_to_share(tmp_path: Path, arm: Path) -> None:
    program = write(tmp_path / "opt" / "lib" / "arm" / "driver", "\x7fELF")
    assert find(arm, "driver", CMAKE_PREFIX_PATH=str(tmp_path / "opt")) == program
    assert find(None, "driver", CMAKE_PREFIX_PATH=str(tmp_path / "opt")) == program
    share = tmp_path / "opt" / "share" / "arm"
    share.mkdir(parents=True)
    assert find(share, "driver") == program


def test_a_python_script_that_is_not_marked_executable_still_runs(arm: Path) -> None:
    script = write(arm / "scripts" / "move.py", executable=False)
    assert find(arm, "move.py") == script


def test_other_files_must_be_executable(arm: Path) -> None:
    write(arm / "scripts" / "move.sh", "#!/bin/sh\n", executable=False)
    with pytest.raises(ConfigError, match=r"not executable; run `chmod \+x .*move.sh`"):
        find(arm, "move.sh")


def test_two_files_with_a_name_need_a_path(arm: Path) -> None:
    write(arm / "a" / "move.py")
    second = write(arm / "b" / "move.py")
    with pytest.raises(ConfigError, match=r"give one of a/move.py, b/move.py"):
        find(arm, "move.py")
    assert find(arm, "b/move.py") == second


def test_build_folders_are_skipped(arm: Path) -> None:
    write(arm / "build" / "move.py")
    script = write(arm / "scripts" / "move.py")
    assert find(arm, "move.py") == script
    assert programs(arm) == [script]


def test_errors_about_missing_programs_list_similar_ones(arm: Path) -> None:
    with pytest.raises(ConfigError, match=f"has no program move.py below {arm}"):
        find(arm, "move.py")
    write(arm / "scripts" / "move.py")
    with pytest.raises(ConfigError, match=r"has no program moves.py; did you mean move.py\?"):
        find(arm, "moves.py")
    with pytest.raises(ConfigError, match=r"has no program x; it has move.py"):
        find(arm, "x")
    with pytest.raises(ConfigError, match=r"package arm was not found"):
        find(None, "x")
    with pytest.raises(ConfigError, match=r"package arm has no scripts/x"):
        find(arm, "scripts/x")


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("a.py", "import rospy\n", True),
        ("a.py", "#!/bin/sh\n", False),
        ("a", "#!/usr/bin/env python\n", True),
        ("a", "#!/usr/bin/python3 -u\r\n", True),
        ("a", "text", False),
    ],
)
def test_python_scripts_are_recognized_by_the_first_line(
    tmp_path: Path, name: str, text: str, expected: bool
) -> None:
    assert is_python(write(tmp_path / name, text)) is expected


def test_a_shebang_has_no_line_end(tmp_path: Path) -> None:
    assert shebang(write(tmp_path / "a", "#!/usr/bin/env python3\r\nx")) == "/usr/bin/env python3"
    assert shebang(tmp_path / "missing") == ""


def test_a_link_and_its_target_are_one_program(arm: Path) -> None:
    script = write(arm / "scripts" / "move.py")
    (arm / "nodes").mkdir()
    (arm / "nodes" / "move.py").symlink_to(script)
    assert find(arm, "move.py").resolve() == script


def test_the_error_about_a_program_that_is_not_built_names_its_source(arm: Path) -> None:
    (arm / "CMakeLists.txt").write_text(
        "project(arm)\n# add_executable(old src/old.cpp)\n"
        "add_executable(${PROJECT_NAME}_driver include/a.h src/driver.cpp src/b.cpp)\n"
        "ADD_EXECUTABLE(long_name\n  src/short.cc)\n"
        "set_target_properties(long_name PROPERTIES OUTPUT_NAME short)\n"
    )
    write(arm / "src" / "alone.cpp", "int main() {}", executable=False)
    for name, source in (("arm_driver", "driver.cpp"), ("short", "short.cc"), ("alone", "alone.cpp")):
        with pytest.raises(ConfigError, match=f"no program {name} yet: it is compiled from src/{source};"):
            find(arm, name)
    with pytest.raises(ConfigError, match="has no program old"):
        find(arm, "old")
    built = write(arm.parents[1] / "devel" / "lib" / "arm" / "arm_driver", "\x7fELF")
    assert find(arm, "arm_driver") == built


def test_modules_are_not_programs(arm: Path) -> None:
    script = write(arm / "scripts" / "move.py")
    write(arm / "scripts" / "helper.py", "#!/usr/bin/env python3\ndef f():\n    pass\n")
    write(arm / "src" / "arm" / "__init__.py", "")
    write(arm / "src" / "arm" / "parts.py", "#!/usr/bin/env python3\nprint('x')\n")
    write(arm / "setup.py")
    assert programs(arm) == [script]
