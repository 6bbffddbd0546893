from __future__ import annotations

from pathlib import Path

import click
import pytest

from rostether.cli.launch import pkg
from unit.cli.command_shell import Shell

CONTEXT = click.Context(click.Command("run"))
PARAMETER = click.Argument(["package"])


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "src").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def arm(workspace: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(workspace / "src")
    shell.output("pkg", "create", "arm", "std_msgs", "rospy")
    monkeypatch.chdir(workspace)
    return workspace / "src" / "arm"


def test_create_prints_the_same_as_catkin_create_pkg(
    workspace: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(workspace / "src")
    assert shell.output(
        "pkg", "create", "arm", "std_msgs", "rospy", "-V", "0.1.0", "-l", "MIT"
    ).splitlines() == [
        "Created file arm/package.xml",
        "Created file arm/CMakeLists.txt",
        "Created folder arm/src",
        f"Successfully created files in {workspace}/src/arm. Please adjust the values in package.xml.",
    ]
    assert "<version>0.1.0</version>" in (workspace / "src" / "arm" / "package.xml").read_text()
    assert "already exists" in shell.failure("pkg", "create", "arm")
    assert shell("pkg", "create", "Arm").err.startswith("Arm: package names should have only")
    assert shell("pkg", "create", "leg", "--json").code == 0


def test_find_and_list(arm: Path, shell: Shell) -> None:
    assert shell.output("pkg", "find", "arm") == f"{arm}\n"
    assert shell.output("pkg", "list") == f"arm {arm}\n"
    assert shell.output("pkg", "list-names") == "arm\n"
    assert shell("pkg", "list", "--json").records == [{"package": "arm", "folder": str(arm)}]
    assert shell.output("pkg", "depends1", "arm") == "catkin\nrospy\nstd_msgs\n"
    assert shell.output("pkg", "version", "arm") == "0.0.0\n"
    assert "did you mean arm?" in shell.failure("pkg", "find", "arn")
    assert "did you mean std_srvs?" in shell.failure("pkg", "find", "std_srv")
    assert "built in and has no folder; `rostether srv package std_srvs`" in shell.failure(
        "pkg", "find", "std_srvs"
    )
    assert "`rostether pkg list` shows those found" in shell.failure("pkg", "find", "xyz")


def test_two_packages_of_one_name(arm: Path, shell: Shell) -> None:
    for number in range(5):
        other = arm.parent / "old" / f"copy{number}"
        other.mkdir(parents=True)
        (other / "package.xml").write_text((arm / "package.xml").read_text())
    found = shell("pkg", "find", "arm")
    assert found.out == f"{arm}\n"
    lines = found.err.splitlines()
    assert len(lines) == 4
    assert lines[0] == (
        f"WARNING: two packages have the name arm: using {arm}, ignoring {arm.parent}/old/copy0; "
        "rename one, or create a file CATKIN_IGNORE in its folder"
    )
    assert lines[3] == "WARNING: 2 more packages have duplicate names"


def test_version_of_the_distribution(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_DISTRO", raising=False)
    assert shell.output("pkg", "version", "-d") == "noetic\n"
    assert "give a package," in shell.failure("pkg", "version", code=2)


def test_make_lists_packages_and_writes_the_setup_file(arm: Path, shell: Shell) -> None:
    (arm / "msg").mkdir()
    (arm / "msg" / "Angles.msg").write_text("int16 a\n")
    workspace = arm.parents[1]
    # As typed for catkin_make.
    text = shell.output("pkg", "make", "-j4", "-DCMAKE_BUILD_TYPE=Release", "--pkg", "arm")
    assert text.splitlines() == [
        "arm (src/arm)",
        "  messages: Angles",
        f"1 package in {workspace / 'src'}; nothing needs to be built",
        f"In other shells, run `source {workspace / 'devel' / 'setup.bash'}`",
    ]
    assert (workspace / "devel" / "setup.bash").is_file()
    assert shell("pkg", "make", "-C", str(workspace), "--json").records == [
        {
            "package": "arm",
            "folder": str(arm),
            "messages": ["Angles"],
            "services": [],
            "actions": [],
            "nodes": [],
            "launch_files": [],
            "problems": [],
        }
    ]


def test_make_fails_for_messages_that_cannot_be_read(arm: Path, shell: Shell) -> None:
    for kind, text in {
        "msg/Bad.msg": "oops",
        "msg/Far.msg": "nowhere_msgs/X x",
        "srv/Bad.srv": "oops\n---",
    }.items():
        (arm / kind).parent.mkdir(exist_ok=True)
        (arm / kind).write_text(text)
    (arm.parent / "broken").mkdir()
    (arm.parent / "broken" / "package.xml").write_text("<package>")
    result = shell("pkg", "make")
    assert result.code == 1
    assert "messages: Bad, Far" in result.out
    for place in ("Bad.msg:1", "nowhere_msgs", "Bad.srv:1", "broken/package.xml:1"):
        assert place in result.err


def test_make_names_packages_that_it_cannot_build(arm: Path, shell: Shell) -> None:
    (arm / "src" / "driver.cpp").touch()
    assert "need a real ROS to build: driver.cpp" in shell.output("pkg", "make")


def test_init_workspace(workspace: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(workspace / "src")
    assert shell.output("pkg", "init-workspace") == f"Created file {workspace / 'src' / 'CMakeLists.txt'}\n"
    assert "already exists" in shell.failure("pkg", "init-workspace")


def test_a_folder_that_is_not_a_workspace(
    tmp_path: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "has no folder src" in shell.failure("pkg", "make")


def test_make_reports_skipped_targets_and_old_scripts(arm: Path, shell: Shell) -> None:
    (arm / "old.py").write_text("#!/usr/bin/env python\nprint 'hello'\n")
    (arm / "old.py").chmod(0o755)
    result = shell("pkg", "make", "install", "run_tests")
    assert result.code == 0
    assert "install: no install folder is made; packages are used where they are" in result.err
    assert "run_tests: no tests are built or run" in result.err
    assert "old.py:2: written for Python 2" in result.err


def test_packages_and_their_programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    folder = tmp_path / "rosy_arm"
    folder.mkdir()
    (folder / "package.xml").write_text("<package><name>rosy_arm</name></package>")
    (folder / "move.py").write_text("#!/usr/bin/env python3\n")
    monkeypatch.chdir(tmp_path)
    assert pkg.complete_package_folders(CONTEXT, PARAMETER, "rosy") == ["rosy_arm"]
    assert "rosserial_python" in pkg.complete_package_folders(CONTEXT, PARAMETER, "ros")
    context = click.Context(click.Command("run"))
    context.params["package"] = "rosy_arm"
    assert pkg.complete_programs(context, PARAMETER, "m") == ["move.py"]
    context.params["package"] = "topic_tools"
    assert pkg.complete_programs(context, PARAMETER, "re") == ["relay"]
    context.params["package"] = "nothing"
    assert pkg.complete_programs(context, PARAMETER, "") == []
