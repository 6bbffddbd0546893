"""Runs plans: parameters, processes with their arguments, environments and logs, respawn, required, stop."""

from __future__ import annotations

import asyncio
import signal
import time
from collections.abc import AsyncIterator, Callable, Mapping
from pathlib import Path

import pytest
import pytest_asyncio

from children import is_running
from loop_watch import LoopWatch
from rostether.errors import ConfigError, UnknownNameError
from rostether.graph.ports import Level
from rostether.launch.command_line import Program, Replaced
from rostether.launch.loading import load_launch
from rostether.launch.node_process import StopLimits
from rostether.launch.plan import LaunchPlan, Output
from rostether.launch.runner import RunOptions, outermost, run_plan
from rostether.launch.substitution import LaunchContext
from rostether.packages.executables import find_program
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.master_client import MasterClient

TIMEOUT_S = 60.0


class Stage:
    """A master, a folder with scripts as nodes, and the lines that a run reports."""

    def __init__(self, folder: Path, master: MasterServer) -> None:
        self.folder = folder
        self.uri = master.uri
        self.client = MasterClient(master.uri, "/test")
        self.lines: list[tuple[Level, str]] = []
        self.environ = {"PATH": "/usr/bin:/bin", "ROS_HOME": str(folder / "home"), "WHERE": str(folder)}

    def script(self, name: str, text: str) -> None:
        file = self.folder / name
        file.write_text(f"#!/bin/sh\n{text}\n")
        file.chmod(0o755)

    def plan(self, body: str) -> LaunchPlan:
        context = LaunchContext(self.environ, {})
        return load_launch([], {}, context, text=f"<launch>{body}</launch>".encode())

    def locate(self, package: str, node_type: str, environ: Mapping[str, str]) -> Program | Replaced:
        if package == "rviz":
            return Replaced("rviz is not installed here; look elsewhere")
        if not (self.folder / node_type).exists():
            raise ConfigError(f"package {package} has no program {node_type}")
        return Program([str(self.folder / node_type)], {"FROM_LOCATE": environ.get("MODE", "none")})

    async def run(self, body: str, **options: object) -> bool:
        return await run_plan(
            self.plan(body),
            master_uri=self.uri,
            environ=self.environ,
            locate=self.locate,
            report=lambda level, text: self.lines.append((level, text)),
            options=RunOptions(**options),  # type: ignore[arg-type]
        )

    @property
    def text(self) -> str:
        return "\n".join(text for _, text in self.lines)

    def read(self, name: str) -> str:
        file = self.folder / name
        return file.read_text() if file.exists() else ""

    def log(self, name: str) -> str:
        return self.read(f"home/log/latest/{name}-stdout.log")

    async def wait_ended(self, pid: int) -> None:
        """Wait for the end of a process, because a killed process may end later on a busy machine."""
        await self.until(lambda: not is_running(pid))

    async def until(self, condition: Callable[[], object]) -> None:
        deadline_s = time.monotonic() + TIMEOUT_S
        while not condition():
            assert time.monotonic() < deadline_s, self.text
            await asyncio.sleep(0.01)


@pytest_asyncio.fixture
async def stage(tmp_path: Path) -> AsyncIterator[Stage]:
    master = await MasterServer.start(port=0)
    stage = Stage(tmp_path, master)
    yield stage
    await stage.client.close()
    await master.close()


async def ended(task: asyncio.Task[bool]) -> None:
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await asyncio.wait_for(task, TIMEOUT_S)


async def test_parameters_are_dumped_deleted_cleared_then_set(stage: Stage) -> None:
    await stage.client.set_param("/old", {"a": 1, "b": 2})
    await stage.client.set_param("/cleared", {"gone": 1})
    await stage.client.set_param("/kept", 1)
    dump = stage.folder / "dump.yaml"
    assert await stage.run(
        f'<rosparam command="dump" file="{dump}" param="old"/><rosparam command="delete" param="old/a"/>'
        '<rosparam command="delete" param="never"/>'
        '<group ns="cleared" clear_params="true"><param name="new" value="1"/></group>'
        '<group ns="cleared/below" clear_params="true"/><param name="x" value="0.5"/>'
    )
    assert dump.read_text() == "a: 1\nb: 2\n"
    assert await stage.client.get_param("/old") == {"b": 2}
    assert await stage.client.get_param("/cleared") == {"new": 1}
    assert await stage.client.get_param("/kept") == 1
    assert await stage.client.get_param("/x") == 0.5
    assert (Level.WARN, "parameter /never is not set; nothing was deleted") in stage.lines


async def test_private_name_of_rosparam_has_the_same_full_name_as_in_roslaunch(stage: Stage) -> None:
    await stage.run('<rosparam param="~x">1</rosparam>')
    assert await stage.client.get_param("/roslaunch/x") == 1


async def test_node_gets_its_arguments_environment_and_folder(stage: Stage) -> None:
    stage.script("print.sh", 'for each; do echo "<$each>"; done; env; pwd')
    assert await stage.run(
        '<node name="n" pkg="p" type="print.sh" ns="arm" args="one &quot;two three&quot;">'
        '<remap from="a" to="b"/><env name="MODE" value="fast"/></node>'
    )
    lines = stage.log("arm-n-1").splitlines()
    assert lines[:4] == ["<one>", "<two three>", "<a:=b>", "<__name:=n>"]
    assert lines[4].startswith("<__log:=")
    assert lines[4].endswith("/arm-n-1.log>")
    assert lines[-1] == str(stage.folder / "home")
    for variable in ("ROS_NAMESPACE=/arm", "MODE=fast", "FROM_LOCATE=fast", f"ROS_MASTER_URI={stage.uri}"):
        assert variable in lines


async def test_logs_of_a_run_are_in_a_folder_with_its_id(stage: Stage) -> None:
    stage.script("print.sh", "echo hello")
    await stage.client.set_param("/run_id", "the-run")
    await stage.run('<node name="n" pkg="p" type="print.sh"/>')
    assert stage.read("home/log/the-run/n-1-stdout.log") == "hello\n"


async def test_run_id_cannot_name_another_folder(stage: Stage) -> None:
    stage.script("print.sh", "echo hello")
    await stage.client.set_param("/run_id", "../../outside")
    await stage.run('<node name="n" pkg="p" type="print.sh"/>')
    assert not (stage.folder / "outside").exists()
    assert stage.log("n-1") == "hello\n"


async def test_working_folder_can_be_that_of_the_program(stage: Stage) -> None:
    stage.script("print.sh", "pwd")
    await stage.run('<node name="n" pkg="p" type="print.sh" cwd="node"/>')
    assert stage.log("n-1").strip() == str(stage.folder)


async def test_launch_prefix_comes_before_the_program(stage: Stage) -> None:
    stage.script("print.sh", "echo $0 $VALUE")
    await stage.run("""<node name="n" pkg="p" type="print.sh" launch-prefix="env 'VALUE=a b'"/>""")
    assert stage.log("n-1") == f"{stage.folder}/print.sh a b\n"


async def test_output_of_all_nodes_can_be_logged(stage: Stage) -> None:
    stage.script("print.sh", "echo hello")
    await stage.run('<node name="n" pkg="p" type="print.sh" output="screen"/>', output=Output.LOG)
    assert stage.log("n-1") == "hello\n"


async def test_node_with_respawn_is_restarted_and_its_log_continues(stage: Stage) -> None:
    stage.script(
        "once.sh",
        'echo "start"; echo x >> "$WHERE/starts"; [ $(wc -l < "$WHERE/starts") -lt 3 ] || sleep 100',
    )
    task = asyncio.create_task(stage.run('<node name="n" pkg="p" type="once.sh" respawn="true"/>'))
    await stage.until(lambda: stage.read("starts").count("x") == 3)
    await stage.until(lambda: stage.log("n-1") == "start\n" * 3)
    await ended(task)
    assert stage.text.count("restarting process") == 2


async def test_node_waits_for_the_respawn_delay(stage: Stage) -> None:
    stage.script("end.sh", 'date +%s.%N >> "$WHERE/starts"')
    task = asyncio.create_task(
        stage.run('<node name="n" pkg="p" type="end.sh" respawn="true" respawn_delay="0.5"/>')
    )
    await stage.until(lambda: stage.read("starts").count("\n") >= 2)
    await ended(task)
    first, second, *_ = map(float, stage.read("starts").split())
    assert second - first >= 0.5


@pytest.mark.parametrize(("code", "succeeds"), [(0, True), (3, False)])
async def test_end_of_a_required_node_ends_all(stage: Stage, code: int, succeeds: bool) -> None:
    stage.script("stay.sh", 'echo $$ > "$WHERE/pid"; exec sleep 100')
    stage.script("end.sh", f'while [ ! -s "$WHERE/pid" ]; do sleep 0.01; done; exit {code}')
    body = '<node name="a" pkg="p" type="stay.sh"/><node name="b" pkg="p" type="end.sh" required="true"/>'
    assert await asyncio.wait_for(stage.run(body), TIMEOUT_S) is succeeds
    await stage.wait_ended(int(stage.read("pid")))
    assert "[b-2] is required" in stage.text


async def test_all_nodes_can_be_required(stage: Stage) -> None:
    stage.script("stay.sh", "exec sleep 100")
    stage.script("end.sh", "exit 0")
    body = '<node name="a" pkg="p" type="stay.sh"/><node name="b" pkg="p" type="end.sh"/>'
    assert await asyncio.wait_for(stage.run(body, all_required=True), TIMEOUT_S)


async def test_failure_is_reported_with_code_command_and_logs(stage: Stage) -> None:
    stage.script("fail.sh", "exit 7")
    assert await stage.run('<node name="n" pkg="p" type="fail.sh" args="x"/>')
    (line,) = [text for level, text in stage.lines if level is Level.ERROR]
    for words in ("[n-1] process has died", "exit code 7", f"{stage.folder}/fail.sh x", "n-1*.log"):
        assert words in line


async def test_a_missing_node_is_reported_with_its_line_and_the_others_run(stage: Stage) -> None:
    stage.script("print.sh", "echo hello")
    body = '\n<node name="a" pkg="p" type="never.sh"/><node name="b" pkg="p" type="print.sh"/>'
    assert await stage.run(body)
    assert stage.log("b-2") == "hello\n"
    assert (Level.ERROR, "<stdin>:2: package p has no program never.sh") in stage.lines


async def test_launch_without_a_node_that_can_start_is_a_failure(stage: Stage) -> None:
    assert not await stage.run('<node name="a" pkg="p" type="never.sh"/>')


async def test_missing_required_node_is_a_failure(stage: Stage) -> None:
    stage.script("stay.sh", "exec sleep 100")
    body = '<node name="a" pkg="p" type="stay.sh"/><node name="b" pkg="p" type="never.sh" required="true"/>'
    assert not await asyncio.wait_for(stage.run(body), TIMEOUT_S)


async def test_replaced_node_is_not_a_failure(stage: Stage) -> None:
    assert await stage.run('<node name="rviz" pkg="rviz" type="rviz"/>')
    assert (Level.WARN, "rviz is not installed here; look elsewhere") in stage.lines


async def test_program_that_cannot_be_executed_is_reported(stage: Stage) -> None:
    (stage.folder / "bad").write_text("#!/does/not/exist\n")
    (stage.folder / "bad").chmod(0o755)
    assert not await stage.run('<node name="a" pkg="p" type="bad"/>')
    assert "cannot run" in stage.text


async def test_working_folder_that_cannot_be_created_is_reported(stage: Stage) -> None:
    stage.script("node", "exit 0")
    (stage.folder / "file").touch()
    stage.environ |= {"ROS_HOME": str(stage.folder / "file"), "ROS_LOG_DIR": str(stage.folder / "log")}
    assert not await stage.run('<node name="a" pkg="p" type="node"/>')
    assert f"cannot write {stage.folder / 'file'}: File exists; choose another name" in stage.text


async def test_stop_interrupts_first_so_that_nodes_can_clean_up(stage: Stage) -> None:
    stage.script("polite.sh", "trap 'echo goodbye; exit 0' INT; echo ready; while :; do sleep 0.05; done")
    task = asyncio.create_task(stage.run('<node name="n" pkg="p" type="polite.sh"/>'))
    await stage.until(lambda: "ready" in stage.log("n-1"))
    await ended(task)
    assert stage.log("n-1") == "ready\ngoodbye\n"


@pytest.mark.parametrize("ignored", ["INT", "INT TERM"])
async def test_stop_escalates_if_a_signal_is_ignored(stage: Stage, ignored: str) -> None:
    stage.script("deaf.sh", f"trap '' {ignored}; echo $$; while :; do sleep 0.05; done")
    limits = StopLimits(sigint_s=0.2, sigterm_s=0.2 if "TERM" in ignored else TIMEOUT_S)
    task = asyncio.create_task(stage.run('<node name="n" pkg="p" type="deaf.sh"/>', stop_limits=limits))
    await stage.until(lambda: stage.log("n-1").endswith("\n"))
    await ended(task)
    await stage.wait_ended(int(stage.log("n-1")))
    assert "did not end within 0.2 s of SIGINT" in stage.text
    assert ("SIGTERM" in stage.text) is ("TERM" in ignored)


async def test_child_processes_of_a_node_end_with_it(stage: Stage) -> None:
    stage.script("parent.sh", '(trap "" INT; echo $$; sleep 100) & echo $! > "$WHERE/child"; exec sleep 100')
    task = asyncio.create_task(stage.run('<node name="n" pkg="p" type="parent.sh"/>'))
    await stage.until(lambda: stage.read("child").endswith("\n"))
    child = int(stage.read("child"))
    assert is_running(child)
    await ended(task)
    await stage.wait_ended(child)


async def test_child_processes_that_outlive_a_node_are_ended(stage: Stage) -> None:
    stage.script("parent.sh", 'sleep 100 & echo $! > "$WHERE/child"')
    assert await asyncio.wait_for(stage.run('<node name="n" pkg="p" type="parent.sh"/>'), TIMEOUT_S)
    await stage.wait_ended(int(stage.read("child")))


async def test_launch_with_the_master_continues_after_its_nodes(stage: Stage) -> None:
    stage.script("print.sh", "echo hello")
    task = asyncio.create_task(stage.run('<node name="n" pkg="p" type="print.sh"/>', stays=True))
    await stage.until(lambda: "until Ctrl-C" in stage.text)
    assert not task.done()
    await ended(task)


async def test_launch_with_only_parameters_sets_them_and_ends(stage: Stage) -> None:
    assert await stage.run('<param name="x" value="1"/>')
    assert await stage.client.get_param("/x") == 1


async def test_dump_that_cannot_be_written_starts_nothing(stage: Stage) -> None:
    stage.script("print.sh", 'echo x > "$WHERE/started"')
    with pytest.raises(ConfigError, match="cannot write"):
        await stage.run(
            '<rosparam command="dump" file="/does/not/exist/x.yaml"/><node name="n" pkg="p" type="print.sh"/>'
        )
    assert not (stage.folder / "started").exists()


async def test_clearing_the_root_deletes_all_parameters(stage: Stage) -> None:
    await stage.client.set_param("/old", 1)
    await stage.run('<rosparam command="delete"/>')
    with pytest.raises(UnknownNameError):
        await stage.client.get_param("/old")


async def test_a_node_killed_by_a_signal_is_reported(stage: Stage) -> None:
    stage.script("die.sh", "kill -SEGV $$")
    await stage.run('<node name="n" pkg="p" type="die.sh"/>')
    assert f"exit code {-signal.SIGSEGV}" in stage.text


async def test_stop_during_a_start_ends_the_process(stage: Stage) -> None:
    stage.script("stay.sh", 'echo $$ > "$WHERE/pid"; exec sleep 100')
    for _ in range(20):
        (stage.folder / "pid").unlink(missing_ok=True)
        task = asyncio.create_task(stage.run('<node name="n" pkg="p" type="stay.sh"/>'))
        await stage.until(lambda: (stage.folder / "home/log/latest/n-1-stdout.log").exists())
        await ended(task)
        if pid := stage.read("pid"):
            await stage.wait_ended(int(pid))


async def test_search_for_programs_does_not_block_the_loop(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = LoopWatch(monkeypatch)
    stage.script("print.sh", "true")

    def locate(package: str, node_type: str, environ: Mapping[str, str]) -> Program:
        return Program([str(find_program(package, node_type, stage.folder, environ))], {})

    monkeypatch.setattr(stage, "locate", locate)
    assert await stage.run('<node pkg="p" type="print.sh" name="a"/>')
    assert watch.folders
    assert watch.held == 0


@pytest.mark.parametrize(
    ("namespaces", "kept"),
    [
        ([], []),
        (["/a/"], ["/a/"]),
        (["/a/", "/a/"], ["/a/"]),
        (["/a/b/", "/a/", "/ab/"], ["/a/", "/ab/"]),
        (["/a/", "/", "/b/c/"], ["/"]),
    ],
)
def test_nested_namespaces_are_cleared_once(namespaces: list[str], kept: list[str]) -> None:
    assert outermost(namespaces) == kept
