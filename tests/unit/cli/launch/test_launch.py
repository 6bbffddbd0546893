"""`rostether launch`: how it finds files, what it lists, and complete launches with processes."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click
import pytest
import yaml

from children import is_running
from interop.ros1_peers import free_port
from programs import running
from rostether.cli.launch.launch import complete_launch
from rostether.cli.main import main
from unit.cli.command_shell import LiveGraph

TIMEOUT_S = 60.0
STAY = '#!/bin/sh\necho "hello from $1"\necho $$ > "$ROS_HOME/$1.pid"\nexec sleep 100\n'
DISPLAY = """<launch>
  <arg name="rate" default="10" doc="how often"/>
  <arg name="port"/>
  <arg name="model" value="arm"/>
  <param name="rate" value="$(arg rate)"/>
  <param name="here" value="$(find arm)"/>
  <node name="mover" pkg="arm" type="stay.sh" args="mover" ns="left"><env name="MODE" value="a b"/></node>
  <include file="$(dirname)/more.xml"/>
</launch>
"""
MORE = '<launch>\n  <node name="$(anon other)" pkg="arm" type="stay.sh" args="other"/>\n</launch>\n'


@pytest.fixture
def arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "ws" / "src" / "arm"
    for name, text in {
        "package.xml": "<package><name>arm</name></package>",
        "launch/display.launch": DISPLAY,
        "launch/more.xml": MORE,
        "launch/stay.launch": '<launch><node name="stay" pkg="arm" type="stay.sh" args="stay"/></launch>',
        "launch/params.launch": '<launch><param name="x" value="1"/></launch>',
        "scripts/stay.sh": STAY,
    }.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    (folder / "scripts" / "stay.sh").chmod(0o755)
    monkeypatch.chdir(tmp_path / "ws")
    for name in ("ROS_PACKAGE_PATH", "ROS_NAMESPACE", "ROS_MASTER_URI"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("ROS_HOME", str(tmp_path))
    return folder


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["launch", *arguments]) == 0
    return capsys.readouterr().out


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["launch", *arguments]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    return line


def test_nodes_are_listed(arm: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mover, other = printed(capsys, "arm", "display.launch", "--nodes").split()
    assert mover == "/left/mover"
    assert other.startswith("/other_")


def test_parameters_are_listed_as_yaml(arm: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "arm", "display.launch", "--dump-params", "rate:=20")
    assert yaml.safe_load(text) == {"/rate": 20, "/here": str(arm)}


def test_arguments_are_listed_as_roslaunch_does(arm: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert printed(capsys, "arm", "display.launch", "--ros-args").splitlines() == [
        "Required Arguments:",
        "  port: undocumented",
        "Optional Arguments:",
        '  rate (default "10"): how often',
    ]


def test_files_are_listed(arm: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = ["display.launch", "more.xml"]
    listed = printed(capsys, "arm", "display.launch", "--files").split()
    assert listed == [str(arm / "launch" / name) for name in names]


def test_node_is_found_in_the_file_that_declares_it(arm: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = printed(capsys, "arm", "display.launch", "--find-node", "/left/mover").strip()
    assert found == str(arm / "launch" / "display.launch")


@pytest.mark.parametrize("name", ["/left/mover", "left/mover", "mover"])
def test_command_line_of_a_node_can_be_typed(
    arm: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    text = printed(capsys, "arm", "display.launch", "--args", name)
    assert "MODE='a b'" in text
    assert "ROS_NAMESPACE=/left" in text
    assert text.rstrip().endswith(f"{arm}/scripts/stay.sh mover __name:=mover")


def test_unknown_node_is_refused_with_the_known_names(arm: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "/left/mover" in refused(capsys, "arm", "display.launch", "--args", "nobody")


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["arn", "display.launch"], "did you mean arm?"),
        (["arm", "displai.launch"], "did you mean display.launch?"),
        (["arm", "zzz"], "it has display.launch, more.xml, params.launch, stay.launch"),
        (["nothing.launch"], "there is no launch file nothing.launch"),
        (["/"], "/ is a folder; give a launch file in it"),
        ([], "give a launch file"),
        (["-", "-"], "once"),
    ],
)
def test_missing_names_are_refused_with_similar_ones(
    arm: Path, capsys: pytest.CaptureFixture[str], words: list[str], reason: str
) -> None:
    assert reason in refused(capsys, *words)


def test_name_that_a_package_has_twice_is_refused(arm: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (arm / "params.launch").write_text("<launch/>")
    assert "give one of params.launch, launch/params.launch" in refused(capsys, "arm", "params.launch")
    assert printed(capsys, "arm", "launch/params.launch", "--dump-params") == "/x: 1\n\n"


def test_error_has_file_and_line_and_exit_code_1(arm: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (arm / "launch" / "bad.launch").write_text("<launch>\n  <node/>\n</launch>")
    assert refused(capsys, "arm", "bad.launch").startswith(f"rostether: error: {arm}/launch/bad.launch:2: ")


def test_two_listings_at_once_are_a_usage_error(arm: Path) -> None:
    assert main(["launch", "arm", "display.launch", "--nodes", "--files"]) == 2


def test_file_given_by_its_path_sees_the_packages_around_it(
    arm: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    text = printed(capsys, str(arm / "launch" / "display.launch"), "--dump-params")
    assert yaml.safe_load(text)["/here"] == str(arm)


def test_xacro_without_its_package_is_the_command_of_rostether(
    arm: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("xacro")
    (arm / "arm.xacro").write_text(
        '<robot name="arm" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:arg name="n" default="a"/>'
        '<link name="$(arg n)_$(find arm)"/></robot>'
    )
    (arm / "x.launch").write_text(
        '<launch><param name="robot" command="$(find xacro)/xacro --inorder '
        '$(find arm)/arm.xacro n:=b"/></launch>'
    )
    model = yaml.safe_load(printed(capsys, "arm", "x.launch", "--dump-params"))["/robot"]
    assert f'<link name="b_{arm}"/>' in model


@pytest.mark.parametrize(
    ("words", "typed", "found"),
    [((), "a", ["arm"]), ((), "x", []), (("arm",), "p", ["params.launch"]), (("other",), "p", [])],
)
def test_packages_and_their_launch_files_complete(
    arm: Path, words: tuple[str, ...], typed: str, found: list[str]
) -> None:
    context = click.Context(click.Command("launch"))
    context.params["words"] = words
    assert complete_launch(context, click.Argument(["words"]), typed) == found


def test_launch_file_of_ros2_is_refused_by_name(arm: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (arm / "x.launch.py").write_text("def generate_launch_description(): pass")
    (arm / "x.launch.yaml").write_text("launch: []")
    for name in ("x.launch.py", "x.launch.yaml"):
        assert "a launch file of ROS 2" in refused(capsys, "arm", name)
    (arm / "x.launch.xml").write_text('<launch><node pkg="arm" exec="talker" name="talker"/></launch>')
    assert "exec= is of ROS 2; in a ROS 1 launch file write type=" in refused(capsys, "arm", "x.launch.xml")


@contextmanager
def launched(
    *arguments: str, master_uri: str, cwd: Path, stdin: int = subprocess.DEVNULL
) -> Iterator[subprocess.Popen[str]]:
    with running(
        *("launch", *arguments),
        cwd=cwd,
        stdin=stdin,
        stderr=subprocess.STDOUT,
        ROS_HOME=str(cwd),
        ROS_MASTER_URI=master_uri,
    ) as process:
        yield process


def pid_of(name: str, folder: Path) -> int:
    file = folder / f"{name}.pid"
    deadline_s = time.monotonic() + TIMEOUT_S
    while not (file.exists() and file.read_text().endswith("\n")):
        assert time.monotonic() < deadline_s, f"{name} was never started"
        time.sleep(0.02)
    return int(file.read_text())


def wait_gone(pid: int) -> None:
    deadline_s = time.monotonic() + TIMEOUT_S
    while is_running(pid):
        assert time.monotonic() < deadline_s, f"process {pid} is still there"
        time.sleep(0.02)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 0)])
def test_launch_joins_a_master_and_ends_its_nodes_on_request(
    arm: Path, graph: LiveGraph, number: signal.Signals, code: int
) -> None:
    with launched("arm", "stay.launch", "--screen", master_uri=graph.uri, cwd=arm) as process:
        pid = pid_of("stay", arm)
        process.send_signal(number)
        output, _ = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == code, output
    assert "hello from stay" in output
    assert "stay (arm/stay.sh)" in output
    wait_gone(pid)


def test_nodes_do_not_outlive_a_launch_that_is_killed(arm: Path, graph: LiveGraph) -> None:
    with launched("arm", "stay.launch", master_uri=graph.uri, cwd=arm) as process:
        pid = pid_of("stay", arm)
        process.kill()
        process.communicate(timeout=TIMEOUT_S)
    wait_gone(pid)


def test_launch_is_the_master_where_there_is_none(arm: Path) -> None:
    (arm / "ask.launch").write_text(
        '<launch><param name="x" value="5"/><node name="ask" pkg="arm" type="ask.sh" required="true" '
        'output="screen"/></launch>'
    )
    script = arm / "scripts" / "ask.sh"
    script.write_text(f"#!/bin/sh\nexec {sys.executable} -m rostether param get /x\n")
    script.chmod(0o755)
    uri = f"http://localhost:{free_port()}"
    with launched("arm", "ask.launch", "--no-summary", master_uri=uri, cwd=arm) as process:
        output, _ = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0, output
    assert "Started a ROS master" in output
    assert re.search(r"^5$", output, re.MULTILINE)
    assert "SUMMARY" not in output


def test_launch_file_can_come_from_stdin(arm: Path, graph: LiveGraph) -> None:
    text = '<launch><param name="from_stdin" value="$(arg v)"/></launch>'
    with launched("-", "v:=7", master_uri=graph.uri, cwd=arm, stdin=subprocess.PIPE) as process:
        output, _ = process.communicate(text, timeout=TIMEOUT_S)
    assert process.returncode == 0, output
    assert graph.do(graph.node("ask").get_param("/from_stdin")) == 7


def test_unused_arguments_cause_a_warning(arm: Path, graph: LiveGraph) -> None:
    arguments = ("arm", "params.launch", "x:=", "ghost:=1")
    with launched(*arguments, master_uri=graph.uri, cwd=arm) as process:
        output, _ = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0, output
    assert "WARNING: the launch file declares no argument ghost" in output
    assert "WARNING: x:= has no value" in output


def test_windows_that_are_not_installed_are_views_of_the_dashboard(arm: Path, graph: LiveGraph) -> None:
    (arm / "launch" / "view.launch").write_text(
        '<launch><node name="view" pkg="rviz" type="rviz" args="-d a.rviz" required="true"/>'
        '<node name="graph" pkg="rqt_graph" type="rqt_graph" required="true"/></launch>'
    )
    with launched("arm", "view.launch", master_uri=graph.uri, cwd=arm.parent) as process:
        text = ""
        assert process.stdout is not None
        while "all nodes have ended; the launch continues until Ctrl-C" not in text:
            line = process.stdout.readline()
            assert line, text
            text += line
        assert re.search(r"Dashboard: http://127\.0\.0\.1:\d+", text)
        assert "rviz is not installed here; the dashboard shows the robot in 3D" in text
        assert "cannot read a.rviz: No such file" in text
        assert re.search(r"Dashboard, scene: http://127\.0\.0\.1:\d+/#/scene", text)
        assert re.search(r"Dashboard, graph: http://127\.0\.0\.1:\d+/#/graph", text)
        process.send_signal(signal.SIGINT)
        assert process.wait(TIMEOUT_S) == 130


def test_served_node_runs_with_its_remaps(arm: Path, graph: LiveGraph) -> None:
    (arm / "served.launch").write_text(
        '<launch><node name="relayed" pkg="rosserial_python" type="serial_node.py" args="tcp 0"/></launch>'
    )
    with launched("arm", "served.launch", master_uri=graph.uri, cwd=arm):
        watcher = graph.node("watcher")
        deadline_s = time.monotonic() + TIMEOUT_S
        while "/relayed" not in graph.do(watcher.snapshot()).nodes:
            assert time.monotonic() < deadline_s, "the node never joined"
            time.sleep(0.05)


def test_packages_beyond_the_limit_of_an_environment_do_not_stop_a_launch(
    arm: Path, graph: LiveGraph
) -> None:
    for number in range(700):
        folder = arm.parent / f"{'p' * 200}{number}"
        folder.mkdir()
        (folder / "package.xml").write_text(f"<package><name>p{number}</name></package>")
    with launched("arm", "stay.launch", master_uri=graph.uri, cwd=arm.parent.parent) as process:
        pid = pid_of("stay", arm.parent.parent)
        process.send_signal(signal.SIGTERM)
        output, _ = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0, output
    wait_gone(pid)
