from __future__ import annotations

import os
from pathlib import Path

import pytest

from rostether.codegen.library_folder import is_ros_library, write_library_folder
from rostether.errors import CodegenError

OURS = {"src/ros.h": b"", "src/ros/node_handle.h": b"", "src/std_msgs/String.h": b"// 1"}
ESTABLISHED = {"ros.h": b"", "ros/node_handle.h": b"", "duration.cpp": b"", "std_msgs/String.h": b""}


def files(folder: Path) -> dict[str, bytes]:
    return {
        file.relative_to(folder).as_posix(): file.read_bytes() for file in folder.rglob("*") if file.is_file()
    }


def names(folder: Path) -> list[str]:
    return [entry.name for entry in folder.iterdir()]


def write(folder: Path, content: dict[str, bytes]) -> None:
    for path, data in content.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)


def test_a_new_folder_with_its_parents(tmp_path: Path) -> None:
    target = tmp_path / "sketchbook" / "libraries" / "ros_lib"
    assert not write_library_folder(target, OURS)
    assert files(target) == OURS
    assert is_ros_library(target)
    assert names(target.parent) == ["ros_lib"]
    assert target.stat().st_mode & 0o777 == target.parent.stat().st_mode & 0o777


@pytest.mark.parametrize("old", [OURS | {"src/old/Old.h": b""}, ESTABLISHED], ids=["ours", "established"])
def test_an_older_library_is_replaced_as_a_whole(old: dict[str, bytes], tmp_path: Path) -> None:
    target = tmp_path / "ros_lib"
    write(target, old)
    assert write_library_folder(target, OURS)
    assert files(target) == OURS
    assert names(tmp_path) == ["ros_lib"]


def test_files_that_did_not_change_keep_their_times(tmp_path: Path) -> None:
    target = tmp_path / "ros_lib"
    write_library_folder(target, OURS)
    for path in OURS:
        os.utime(target / path, (1_000_000_000, 1_000_000_000))
    write_library_folder(target, OURS | {"src/std_msgs/String.h": b"// 2"})
    assert (target / "src/ros.h").stat().st_mtime == 1_000_000_000
    assert (target / "src/std_msgs/String.h").stat().st_mtime > 1_600_000_000


@pytest.mark.parametrize(
    ("old", "reason"),
    [
        ({"precious.txt": b"mine"}, "is not a generated library and is not changed"),
        ({"ros.h": b""}, "is not a generated library"),
        (OURS | {".git/config": b""}, "is a git repository and is not changed;"),
    ],
)
def test_other_folders_are_never_changed(old: dict[str, bytes], reason: str, tmp_path: Path) -> None:
    target = tmp_path / "ros_lib"
    write(target, old)
    with pytest.raises(CodegenError, match=reason):
        write_library_folder(target, OURS)
    assert files(target) == old


def test_a_file_at_the_path_of_the_library_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "ros_lib").write_text("mine")
    with pytest.raises(CodegenError, match="is a file; remove it"):
        write_library_folder(tmp_path / "ros_lib", OURS)
    with pytest.raises(CodegenError, match=r"cannot write .*; choose a writable folder"):
        write_library_folder(tmp_path / "ros_lib" / "deeper" / "ros_lib", OURS)


def test_an_empty_folder_and_a_link_are_filled(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "ros_lib").symlink_to(tmp_path / "elsewhere")
    assert not write_library_folder(tmp_path / "ros_lib", OURS)
    assert write_library_folder(tmp_path / "ros_lib", OURS)
    assert (tmp_path / "ros_lib").is_symlink()
    assert files(tmp_path / "elsewhere") == OURS


@pytest.mark.parametrize("failure", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("at", ["write", "swap"])
def test_a_failed_run_does_not_change_the_old_library(
    at: str, failure: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "ros_lib"
    write(target, ESTABLISHED)
    rename, write_bytes = Path.rename, Path.write_bytes

    def failing_rename(path: Path, new: Path) -> Path:
        if path.name == "new":
            raise failure
        return rename(path, new)

    def failing_write(path: Path, data: bytes) -> int:
        if path.name == "String.h":
            raise failure
        return write_bytes(path, data)

    if at == "swap":
        monkeypatch.setattr(Path, "rename", failing_rename)
    else:
        monkeypatch.setattr(Path, "write_bytes", failing_write)
    is_interrupt = isinstance(failure, KeyboardInterrupt)
    expected, text = (KeyboardInterrupt, None) if is_interrupt else (CodegenError, "; free some space")
    with pytest.raises(expected, match=text):
        write_library_folder(target, OURS)
    assert files(target) == ESTABLISHED
    assert names(tmp_path) == ["ros_lib"]
