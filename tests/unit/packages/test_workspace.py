from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.packages.locate import workspace_of
from rostether.packages.workspace import (
    broken_packages,
    init_workspace,
    read_workspace,
    write_setup_files,
)


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    init_workspace(tmp_path / "my ws" / "src")
    return tmp_path / "my ws"


def write(file: Path, text: str = "", *, executable: bool = False) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    if executable:
        file.chmod(0o755)


def make_arm(workspace: Path) -> Path:
    arm = workspace / "src" / "arm"
    write(arm / "package.xml", "<package><name>arm</name></package>")
    write(arm / "msg" / "Angles.msg", "int16 a\n")
    write(arm / "srv" / "Move.srv", "---\n")
    write(arm / "action" / "Grip.action", "---\n---\n")
    write(arm / "scripts" / "move.py", "#!/usr/bin/env python3\n", executable=True)
    write(arm / "setup.py", "#!/usr/bin/env python3\n")
    write(arm / "launch" / "arm.launch", "<launch/>")
    write(arm / "src" / "driver.cpp")
    return arm


def test_a_folder_is_marked_once(workspace: Path) -> None:
    assert workspace_of(workspace) == workspace
    with pytest.raises(ConfigError, match="already exists"):
        init_workspace(workspace / "src")


def test_the_contents_of_a_workspace(workspace: Path) -> None:
    arm = make_arm(workspace)
    (contents,) = read_workspace(workspace)
    assert contents.folder == arm
    assert contents.description.name == "arm"
    assert (contents.messages, contents.services, contents.actions) == (["Angles"], ["Move"], ["Grip"])
    assert contents.nodes == ["move.py"]
    assert contents.launch_files == ["arm.launch"]
    assert contents.compiled_sources == ["driver.cpp"]
    assert broken_packages(workspace) == []


def test_broken_packages_are_named(workspace: Path) -> None:
    write(workspace / "src" / "bad" / "package.xml", "<package>")
    assert read_workspace(workspace) == []
    (line,) = broken_packages(workspace)
    assert "bad/package.xml:1: not XML" in line


def test_rosbuild_manifests_are_read(workspace: Path) -> None:
    write(workspace / "src" / "arm" / "manifest.xml", "<package><license>BSD</license></package>")
    write(workspace / "src" / "bad" / "manifest.xml", "<package>")
    (contents,) = read_workspace(workspace)
    assert (contents.description.name, contents.description.licenses) == ("arm", ("BSD",))
    (line,) = broken_packages(workspace)
    assert "bad/manifest.xml:1: not XML" in line


def test_a_folder_without_src_is_not_a_workspace(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="has no folder src"):
        read_workspace(tmp_path)


@pytest.mark.parametrize(("before", "after"), [("", "{src}"), ("/other", "{src}:/other")])
def test_sourcing_the_setup_file_shows_the_packages_once(workspace: Path, before: str, after: str) -> None:
    written = write_setup_files(workspace)
    assert {file.name for file in written} == {"setup.sh", "setup.bash", "setup.zsh", "setup.fish"}
    script = '. "$1"; . "$1"; echo "$ROS_PACKAGE_PATH"'
    reported = subprocess.run(
        ["/bin/sh", "-c", script, "sh", str(workspace / "devel" / "setup.sh")],
        env={"ROS_PACKAGE_PATH": before},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert reported.strip() == after.format(src=workspace / "src")


def test_the_setup_file_of_a_real_build_is_kept(workspace: Path) -> None:
    write(workspace / "devel" / "setup.bash", "# catkin's own")
    assert "setup.bash" not in {file.name for file in write_setup_files(workspace)}
    assert (workspace / "devel" / "setup.bash").read_text() == "# catkin's own"
    # The files of rostether are written again, because the workspace may have moved.
    assert "setup.sh" in {file.name for file in write_setup_files(workspace)}
