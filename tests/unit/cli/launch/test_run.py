from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from programs import ROSTETHER, read_until, running
from rostether.cli.launch.builtin_nodes import BUILTIN_NODES, replacement_line, view_command
from rostether.cli.launch.run import PYTHON_VARIABLE, node_command, python_for
from rostether.cli.launch.shims import SHIM_MARK
from rostether.errors import ConfigError
from unit.cli.command_shell import Shell

SAY = "import json, os, sys\nprint(json.dumps([sys.argv[1:], os.environ.get('PYTHONPATH')]), flush=True)\n"


@pytest.fixture
def arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "src" / "arm"
    (folder / "scripts").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>arm</name></package>")
    monkeypatch.chdir(tmp_path)
    return folder


def write(file: Path, text: str) -> Path:
    file.write_text(text)
    file.chmod(0o755)
    return file


def run(*arguments: str, cwd: Path, **environ: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*ROSTETHER, "run", *arguments],
        cwd=cwd,
        env={**os.environ, **environ},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_a_script_gets_every_argument_and_the_rospy_of_rostether(arm: Path) -> None:
    write(arm / "scripts" / "say.py", f"#!/usr/bin/env python3\n{SAY}")
    done = run("arm", "say.py", "__name:=x", "a:=b", "_p:=1", "-h", "--debug", "", cwd=arm)
    assert done.returncode == 0, done.stderr
    arguments, python_path = json.loads(done.stdout)
    assert arguments == ["__name:=x", "a:=b", "_p:=1", "-h", "--debug", ""]
    assert Path(python_path.split(os.pathsep)[0]).parts[-2:] == ("rospy", "path")


def test_the_command_ends_as_its_program_did(arm: Path) -> None:
    write(arm / "scripts" / "fail.sh", "#!/bin/sh\nexit 7\n")
    assert run("arm", "fail.sh", cwd=arm).returncode == 7
    write(arm / "scripts" / "wait.sh", "#!/bin/sh\necho ready\nexec sleep 60\n")
    with running("run", "arm", "wait.sh", cwd=arm) as process:
        read_until(process, "ready")
        process.send_signal(signal.SIGTERM)
        assert process.wait(60) == -signal.SIGTERM


def test_prefix_and_debug(arm: Path) -> None:
    write(arm / "scripts" / "say.sh", '#!/bin/sh\necho "$FLAG $1"\n')
    done = run("--prefix", "env FLAG='a b'", "-d", "arm", "say.sh", "x", cwd=arm)
    assert done.stdout.splitlines() == [f"env 'FLAG=a b' {arm / 'scripts' / 'say.sh'} x", "a b x"]


def test_a_program_that_cannot_start(arm: Path) -> None:
    write(arm / "scripts" / "odd.sh", "#!/no/such/shell\n")
    done = run("arm", "odd.sh", cwd=arm)
    assert done.returncode == 1
    assert done.stderr.startswith("rostether: error: ")
    assert (
        "cannot be run: No such file or directory; check the path and the first line of the program"
        in done.stderr
    )


def test_missing_names_are_reported_with_similar_ones(arm: Path, shell: Shell) -> None:
    write(arm / "scripts" / "move.py", "#!/usr/bin/env python3\n")
    assert "did you mean move.py?" in shell.failure("run", "arm", "mov.py")
    assert "no package arn; did you mean arm?" in shell.failure("run", "arn", "move.py")
    assert "did you mean rosserial_python" in shell.failure("run", "rosserial_pyton", "serial_node.py")
    assert "message_info_service.py, serial_node, serial_node.py" in shell.failure(
        "run", "rosserial_python", "x"
    )
    assert "`rostether pkg list`" in shell.failure("run", "xyzzyx", "x")


def test_established_nodes_run_as_roles(arm: Path) -> None:
    found = node_command("rosserial_python", "serial_node.py", packages={}, environ={})
    assert found == [sys.executable, "-P", "-m", "rostether", "serial-node"]
    # Even if the package itself is in the workspace.
    assert (
        node_command("rosserial_python", "serial_node.py", packages={"rosserial_python": arm}, environ={})
        == found
    )


@pytest.mark.parametrize("node", sorted(BUILTIN_NODES))
def test_every_served_node_is_a_command_of_rostether(node: tuple[str, str], shell: Shell) -> None:
    words = BUILTIN_NODES[node]
    assert shell.output(*words, "--help").startswith(f"Usage: rostether {' '.join(words)}")


def test_windows_that_are_not_installed_have_a_line(
    tmp_path: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert replacement_line("rviz", {"PATH": str(tmp_path)}) == (
        "rviz is not installed here; the dashboard shows the robot in 3D"
    )
    scene = ["dashboard", "--panel", "scene"]
    for words in (["-d", "x.rviz"], ["--display-config=x.rviz"], ["-f", "base", "x.rviz"]):
        assert view_command("rviz", [*words, "__name:=view"])[4:] == [
            *(*scene, "--show", "x.rviz", "__name:=view")
        ]
    assert view_command("rviz", ["-f", "base"])[4:] == scene
    graph = view_command("rqt_graph", ["-x", "__name:=g", "/arm"], in_terminal=True)
    assert graph[4:] == ["graph", "/arm"]
    assert view_command("rqt_graph", [])[4:] == ["dashboard", "--panel", "graph"]
    plot = view_command("rqt_plot", ["/a/data"], in_terminal=True)
    assert plot[4:] == ["role", "rqt-plot", "/a/data"]
    assert view_command("rqt_plot", ["/a/data"])[4:] == [
        *("dashboard", "--panel", "plots", "--show", "/a/data")
    ]
    assert view_command("rqt_console", [])[4:] == ["dashboard", "--panel", "console"]
    assert view_command("rqt_gui", [])[4:] == ["dashboard"]
    # rostether's view replaces it, and finds no master here.
    done = run(
        "rqt_graph", "rqt_graph", cwd=tmp_path, PATH=str(tmp_path), ROS_MASTER_URI="http://127.0.0.1:1"
    )
    first, second = done.stderr.splitlines()[:2]
    assert first == "rqt_graph is not installed here; `rostether graph` shows nodes and topics"
    assert "no ROS master" in second or "master" in second
    assert done.returncode == 1
    assert replacement_line("rqt_unheard_of", {}) is not None
    assert replacement_line("arm", {}) is None
    shims = tmp_path / "shims"
    shims.mkdir()
    write(shims / "rviz", f"#!/bin/sh\n# {SHIM_MARK}\n")
    assert replacement_line("rviz", {"PATH": str(shims)}) is not None
    write(tmp_path / "rviz", "#!/bin/sh\n")
    assert replacement_line("rviz", {"PATH": f"{shims}:{tmp_path}"}) is None
    assert node_command("rviz", "rviz", packages={}, environ={"PATH": str(tmp_path)}) == [
        str(tmp_path / "rviz")
    ]


def test_a_missing_package_is_an_error(arm: Path) -> None:
    with pytest.raises(ConfigError, match="no package leg"):
        node_command("leg", "x", packages={"arm": arm}, environ={})


def test_which_python_runs_a_script(tmp_path: Path) -> None:
    named = tmp_path / "python3"
    named.symlink_to(sys.executable)
    path = {"PATH": str(tmp_path)}
    script = write(tmp_path / "a.py", "#!/usr/bin/env python3\n")
    assert python_for(script, path) == [str(named)]
    assert python_for(write(tmp_path / "b.py", f"#!{named} -u\r\n"), path) == [str(named), "-u"]
    # The script names no Python, one that does not exist, or one that is too old.
    assert python_for(write(tmp_path / "c.py", "import rospy\n"), path) == [sys.executable]
    assert python_for(write(tmp_path / "d.py", "#!/usr/bin/env python\n"), path) == [sys.executable]
    write(tmp_path / "python2", "#!/bin/sh\necho False\n")
    assert python_for(write(tmp_path / "e.py", "#!/usr/bin/env python2\n"), path) == [sys.executable]
    assert python_for(script, {**path, PYTHON_VARIABLE: "/opt/python"}) == ["/opt/python"]


def test_a_real_rospy_runs_scripts_whose_packages_are_built_for_it(tmp_path: Path) -> None:
    text = f'#!/bin/sh\nPYTHONPATH={tmp_path / "real"} exec {sys.executable} "$@"\n'
    named = write(tmp_path / "python3", text)
    for package in ("rospy", "built"):
        (tmp_path / "real" / package).mkdir(parents=True)
        (tmp_path / "real" / package / "__init__.py").touch()
    # A folder of a package is not a module.
    (tmp_path / "real" / "arm").mkdir()
    built = write(tmp_path / "a.py", f"#!{named}\nimport rospy, sys\nfrom built.msg import Wheels\n")
    assert python_for(built, {}, ["built", "arm"]) == [str(named)]
    unbuilt = write(tmp_path / "b.py", f"#!{named}\nimport rospy\nfrom arm.msg import Angles\n")
    assert python_for(unbuilt, {}, ["built", "arm"]) == [sys.executable]


def test_a_script_for_python_2_is_refused_with_a_command_to_type(arm: Path) -> None:
    script = write(arm / "old.py", "#!/usr/bin/env python\nprint 'hello'\n")
    with pytest.raises(ConfigError, match=r"old\.py:2: written for Python 2; convert it with `2to3 -w"):
        node_command("arm", "old.py", packages={"arm": arm}, environ={})
    # If Python 2 is chosen, it runs.
    environ = {PYTHON_VARIABLE: "/usr/bin/python2.7"}
    assert node_command("arm", "old.py", packages={"arm": arm}, environ=environ)[-1] == str(script)
