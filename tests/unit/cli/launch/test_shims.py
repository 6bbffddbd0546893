from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from rostether.cli.launch.shims import SHIMS, is_shim, shell_code, write_shims
from rostether.cli.shell.own_command import CALLED_AS_VARIABLE
from rostether.cli.verb_table import VERBS
from unit.cli.command_shell import Shell

SHELLS = [name for name in ("sh", "bash", "dash", "zsh") if shutil.which(name)]


@pytest.fixture(autouse=True)
def _cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def shell_lines(shell: str, code: str, path: str, script: str, **environ: str) -> list[str]:
    """Return the lines that a script prints after the code has set up its shell."""
    return subprocess.run(
        [shutil.which(shell, path=os.defpath) or shell, "-c", f"{code}\n{script}"],
        env={"PATH": path, **environ},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    ).stdout.splitlines()


def fake_ros(folder: Path) -> Path:
    folder.mkdir()
    (folder / "rostopic").write_text("#!/bin/sh\necho real\n")
    (folder / "rostopic").chmod(0o755)
    return folder


@pytest.mark.parametrize("name", SHELLS)
def test_the_code_works_in_a_shell_and_may_be_read_twice(name: str, tmp_path: Path) -> None:
    folder = write_shims(tmp_path / "my shims")
    code = shell_code(folder, first=False, is_fish=False)
    reported = shell_lines(name, f"{code}\n{code}", "/usr/bin:/bin", 'echo "$PATH"; command -v rossrun')
    assert reported == [f"/usr/bin:/bin:{folder}", str(folder / "rossrun")]


def test_a_real_ros_is_not_shadowed_unless_asked(
    tmp_path: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = fake_ros(tmp_path / "ros")
    path = str(real)
    monkeypatch.setenv("PATH", path)
    monkeypatch.setenv("SHELL", "/bin/sh")
    behind = shell("env")
    assert behind.code == 0
    assert behind.err.startswith(
        f"a real ROS is installed, and its commands keep precedence ({real / 'rostopic'}"
    )
    assert shell_lines("sh", behind.out, path, "rostopic") == ["real"]
    before = shell.output("env", "--first")
    (where,) = shell_lines("sh", before, path, "command -v rostopic")
    assert is_shim(Path(where))


def test_each_shim_runs_a_command_of_rostether(tmp_path: Path) -> None:
    folder = write_shims()
    assert folder.parent.parent == tmp_path / "cache"
    assert {each.name for each in folder.iterdir()} == set(SHIMS)
    assert {words[0] for words in SHIMS.values() if words} <= set(VERBS)
    assert write_shims() == folder
    assert f"{CALLED_AS_VARIABLE}=rostopic " in (folder / "rostopic").read_text()
    for name in ("rostopic", "rosrun", "catkin_create_pkg"):
        shown = subprocess.run(
            [str(folder / name), "--help"], capture_output=True, text=True, check=True
        ).stdout
        assert shown.startswith(f"Usage: rostether {' '.join(SHIMS[name])}")


def test_a_damaged_shim_is_written_again() -> None:
    folder = write_shims()
    (folder / "rostopic").write_text("half")
    write_shims()
    assert is_shim(folder / "rostopic")
    assert os.access(folder / "rostopic", os.X_OK)


def test_a_shim_imports_no_modules_from_the_current_folder(tmp_path: Path) -> None:
    (tmp_path / "click.py").write_text("raise SystemExit('not this one')")
    shim = write_shims() / "rostopic"
    shown = subprocess.run([str(shim), "--help"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert shown.returncode == 0, shown.stderr


def test_roscd(tmp_path: Path) -> None:
    launch = tmp_path / "src" / "arm" / "launch"
    launch.mkdir(parents=True)
    (launch.parent / "package.xml").write_text("<package><name>arm</name></package>")
    code = shell_code(write_shims(), first=True, is_fish=False)
    script = f'cd "{tmp_path}"; roscd arm; pwd; roscd arm/launch; pwd; roscd nothing || echo failed'
    reported = shell_lines("sh", code, "/usr/bin:/bin", script)
    assert reported == [str(launch.parent), str(launch), "failed"]


def test_a_cache_that_cannot_be_written(
    tmp_path: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert "choose another cache folder with XDG_CACHE_HOME" in shell.failure("env")


@pytest.mark.fish
def test_fish(tmp_path: Path) -> None:
    folder = write_shims(tmp_path / "my shims")
    code = shell_code(folder, first=False, is_fish=True)
    assert shell_lines("fish", f"{code}\n{code}", "/usr/bin:/bin", "count $PATH; command -v rossrun") == [
        "3",
        str(folder / "rossrun"),
    ]
    first = shell_code(folder, first=True, is_fish=True)
    assert shell_lines("fish", f"{code}\n{first}", "/usr/bin:/bin", "echo $PATH[1]") == [str(folder)]


def test_words_of_ros2(tmp_path: Path) -> None:
    folder = write_shims(tmp_path / "shims")
    code = shell_code(folder, first=True, is_fish=False)
    shown = shell_lines("sh", code, "/usr/bin:/bin", "ros2 interface show std_msgs/msg/Header")
    assert shown == ["builtin_interfaces/Time stamp", "\tint32 sec", "\tuint32 nanosec", "string frame_id"]
    # ROS 2 without an option.
    shown = shell_lines("sh", code, "/usr/bin:/bin", "ros2 msg show std_msgs/msg/Header")
    assert shown[0] == "builtin_interfaces/Time stamp"
