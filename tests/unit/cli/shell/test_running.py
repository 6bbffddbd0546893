from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest

from programs import running
from rostether.cli.main import main
from rostether.cli.shell import interrupts
from rostether.cli.shell.failures import EXIT_INTERRUPTED
from rostether.cli.shell.interrupts import raise_at_interrupt
from rostether.cli.shell.running import notifying_systemd, run
from rostether.errors import ConfigError
from unit.cli.command_shell import LiveGraph
from unit.cli.talking import command_node

pytestmark = pytest.mark.slow

ECHO = ("topic", "echo", "/ultrasound/range")


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 143)]
)
@pytest.mark.parametrize("ignores_sigint", [False, True])
def test_a_signal_ends_a_command_that_then_leaves_the_graph(
    graph: LiveGraph, number: signal.Signals, code: int, ignores_sigint: bool
) -> None:
    with running(*ECHO, ignores_sigint=ignores_sigint, ROS_MASTER_URI=graph.uri) as process:
        graph.wait_until(lambda: command_node(graph) is not None)
        process.send_signal(number)
        # `timeout` sends two signals too. They count as one only if they are close, so this cannot sleep.
        sent_s = time.monotonic()
        while time.monotonic() < sent_s + 0.001:
            pass
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == code
    assert errors in ("", "WARNING: topic [/ultrasound/range] does not appear to be published yet\n")
    assert command_node(graph) is None


def test_signals_while_python_exits_do_not_change_the_exit_code(graph: LiveGraph) -> None:
    with running(*ECHO, ROS_MASTER_URI=graph.uri) as process:
        graph.wait_until(lambda: command_node(graph) is not None)
        while process.poll() is None:
            process.send_signal(signal.SIGTERM)
            time.sleep(0.0002)
    assert process.returncode == 143


def test_python_prints_no_warning_about_an_expression(tmp_path: Path) -> None:
    with running("bag", "filter", "a.bag", "b.bag", "1if m else 0", cwd=tmp_path) as process:
        _, errors = process.communicate(timeout=60)
    assert errors == "rostether: error: cannot read a.bag: No such file or directory; check the path\n"


def test_a_service_finishes_its_work_before_it_ends(graph: LiveGraph) -> None:
    with running("core", "--port", "0", ROS_MASTER_URI=graph.uri) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("ROS_MASTER_URI=http://")
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
    assert process.returncode == 0


@pytest.mark.parametrize("command", [["msg", "list"], ["msg", "show", "--help"], ["topic", "list"]])
def test_a_reader_that_stops_early_is_not_an_error(graph: LiveGraph, command: list[str]) -> None:
    with running(*command, ROS_MASTER_URI=graph.uri) as process:
        assert process.stdout is not None
        process.stdout.close()
        process.stdout = None
        _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, "")


def test_errors_of_a_command_are_raised() -> None:
    async def fail() -> None:
        raise ConfigError("wrong")

    with pytest.raises(ConfigError, match="wrong"):
        run(fail())


def test_the_result_comes_back() -> None:
    async def answer() -> int:
        await asyncio.sleep(0)
        return 42

    assert run(answer()) == 42


@pytest.mark.parametrize("is_demanded", [True, None])
def test_uvloop(is_demanded: bool | None, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("uvloop")

    async def kind() -> str:
        return type(asyncio.get_running_loop()).__module__

    assert run(kind(), uvloop=is_demanded) == "uvloop"
    monkeypatch.setitem(sys.modules, "uvloop", None)
    if is_demanded:
        with pytest.raises(ConfigError, match="pip install"):
            run(kind(), uvloop=True)
    else:
        assert "uvloop" not in run(kind(), uvloop=None)


def test_a_signal_in_this_process(graph: LiveGraph, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", graph.uri)

    async def interrupt() -> None:
        os.kill(os.getpid(), signal.SIGINT)
        await asyncio.sleep(20)

    monkeypatch.setattr("rostether.cli.topic.ros1_echo.echo", lambda *_: interrupt())
    assert main(ECHO) == 130


COMPUTES = """
import asyncio, sys, time
from rostether.cli.shell.failures import exit_code_of
from rostether.cli.shell.running import run

def sleep_long():
    # A signal between Python's last check and one long call would be handled only after the call.
    while True:
        time.sleep(1)

async def compute():
    elsewhere = asyncio.create_task(asyncio.sleep(1000))
    try:
        print("computing", flush=True)
        await asyncio.sleep(0)
        {work}
    finally:
        print("left", flush=True)

sys.exit(exit_code_of(lambda: run(compute(), is_service={is_service}, uvloop={uvloop})))
"""


ENDS = [(signal.SIGINT, False, 130), (signal.SIGTERM, False, 143), (signal.SIGTERM, True, 0)]
WORK = [
    ("sleep_long()", False),
    ("sleep_long()", None),
    ("asyncio.get_running_loop().call_soon(sleep_long); await elsewhere", False),
    ("asyncio.get_running_loop().call_soon(sleep_long); await elsewhere", None),
]


@pytest.mark.parametrize(
    ("number", "is_service", "code", "work", "uvloop"),
    [
        *((*end, *work) for end in ENDS for work in WORK),
        # Costs two seconds of a processor.
        (signal.SIGINT, False, 130, "while True: pass", None),
    ],
)
def test_a_signal_interrupts_a_computation(
    number: signal.Signals, is_service: bool, code: int, work: str, uvloop: bool | None
) -> None:
    program = COMPUTES.format(work=work, is_service=is_service, uvloop=uvloop)
    process = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "computing\n"
        process.send_signal(number)
        output, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert (process.returncode, output, errors) == (code, "left\n", "")


def until_sleeping(pid: int) -> None:
    stat = Path(f"/proc/{pid}/stat")
    while stat.read_text().rpartition(")")[2].split()[0] != "S":
        time.sleep(0.01)


READS = """
import sys
from rostether.cli.shell import running
from rostether.cli.shell.failures import exit_code_of

# The test would take this long if the signal waited for the end of the reading.
running.BUSY_S = 1000

async def read():
    try:
        print("reading", flush=True)
        sys.stdin.read()
    finally:
        print("closed", flush=True)

sys.exit(exit_code_of(lambda: running.run(read(), is_service={is_service})))
"""


@pytest.mark.parametrize(("number", "is_service", "code"), ENDS)
def test_a_signal_ends_a_command_that_reads_a_silent_pipe_at_its_start(
    number: signal.Signals, is_service: bool, code: int
) -> None:
    program = READS.format(is_service=is_service)
    process = subprocess.Popen(
        [sys.executable, "-c", program],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "reading\n"
        # Python handles a signal that comes just before the system call only after it, which is never here.
        until_sleeping(process.pid)
        process.send_signal(number)
        assert process.wait(timeout=20) == code
        output, errors = process.communicate()
    finally:
        process.kill()
    assert (output, errors) == ("closed\n", "")


TERMINATED_TWICE = """
import asyncio, os, signal, sys
from rostether.cli.shell.failures import exit_code_of
from rostether.cli.shell.running import run

async def terminated():
    os.kill(os.getpid(), signal.SIGTERM)
    await asyncio.sleep(1000)

code = exit_code_of(lambda: run(terminated(), uvloop={uvloop}))
os.kill(os.getpid(), signal.SIGTERM)
sys.exit(code)
"""


@pytest.mark.parametrize("uvloop", [False, None])
def test_a_second_signal_after_the_command_ended_changes_nothing(uvloop: bool | None) -> None:
    program = TERMINATED_TWICE.format(uvloop=uvloop)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "")


def test_a_cancellation_before_the_signal_handlers_exist_is_an_interrupt() -> None:
    async def cancelled_by_asyncio() -> None:
        raise asyncio.CancelledError

    with pytest.raises(click.exceptions.Exit) as caught:
        run(cancelled_by_asyncio())
    assert caught.value.exit_code == EXIT_INTERRUPTED


def test_ctrl_c_before_the_command_runs_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    ran = []

    async def command() -> None:
        ran.append(1)

    runner = asyncio.Runner

    def interrupted(**options: Any) -> asyncio.Runner:
        os.kill(os.getpid(), signal.SIGINT)
        return runner(**options)

    monkeypatch.setattr(asyncio, "Runner", interrupted)
    before = signal.getsignal(signal.SIGINT)
    try:
        with pytest.raises(click.exceptions.Exit) as caught:
            run(command())
    finally:
        signal.signal(signal.SIGINT, before)
    assert caught.value.exit_code == EXIT_INTERRUPTED
    assert not ran


def test_ctrl_c_that_a_clean_up_lost_ends_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    async def command() -> None:
        pytest.fail("it runs")

    before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    monkeypatch.setattr(interrupts, "_interrupted", False)
    try:
        raise_at_interrupt()
        with contextlib.suppress(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(click.exceptions.Exit) as caught:
            run(command())
    finally:
        signal.signal(signal.SIGINT, before)
    assert caught.value.exit_code == EXIT_INTERRUPTED


def test_ctrl_c_after_a_part_of_a_command_ends_the_next_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupts, "_interrupted", False)
    before = signal.getsignal(signal.SIGINT)
    threads: list[asyncio.Future[None]] = []
    parts: list[asyncio.Task[Any]] = []

    def interrupt() -> None:
        while not parts[0].done():
            time.sleep(0.001)
        os.kill(os.getpid(), signal.SIGINT)

    async def leave_a_thread() -> str:
        task = asyncio.current_task()
        assert task is not None
        parts.append(task)
        # The loop waits for it when the coroutine has ended.
        threads.append(asyncio.get_running_loop().run_in_executor(None, interrupt))
        return "done"

    assert run(leave_a_thread()) == "done"
    with pytest.raises(click.exceptions.Exit) as ending:
        run(asyncio.sleep(60))
    assert ending.value.exit_code == EXIT_INTERRUPTED
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize("runs", ["", "sys.argv[1:] = ['msg', 'md5', 'std_msgs/Empty']; program.main()"])
def test_ctrl_c_before_and_after_the_command_is_silent(runs: str) -> None:
    program = f"""
import os, signal, sys
import rostether.__main__ as program
{runs}
os.kill(os.getpid(), signal.SIGINT)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "")


@pytest.fixture
def manager(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[socket.socket]:
    address = f"@rostether-test-{tmp_path.name}-{os.getpid()}"
    monkeypatch.setenv("NOTIFY_SOCKET", address)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(f"\0{address[1:]}")
        listening.settimeout(60)
        yield listening


async def test_a_service_is_ready_alive_and_stops(
    manager: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The system keeps ten datagrams for a slow reader.
    monkeypatch.setenv("WATCHDOG_USEC", "60000")
    received: list[bytes] = []

    async def main() -> str:
        # Children must not report instead of it.
        assert "NOTIFY_SOCKET" not in os.environ
        while received.count(b"WATCHDOG=1") < 2:
            received.append(await asyncio.to_thread(manager.recv, 100))
        return "done"

    assert await notifying_systemd(main()) == "done"
    manager.setblocking(False)
    while received[-1] != b"STOPPING=1":
        received.append(manager.recv(100))
    assert received[0] == b"READY=1"


async def test_a_blocked_loop_sends_nothing(manager: socket.socket, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WATCHDOG_USEC", "20000")

    async def main() -> None:
        await asyncio.sleep(0.05)
        manager.setblocking(False)
        with pytest.raises(BlockingIOError):
            while True:
                manager.recv(100)
        time.sleep(0.2)
        with pytest.raises(BlockingIOError):
            manager.recv(100)

    await notifying_systemd(main())


async def test_without_a_manager() -> None:
    async def main() -> int:
        return 3

    assert await notifying_systemd(main()) == 3


async def test_a_manager_that_has_ended(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "gone"))

    async def main() -> int:
        await asyncio.sleep(0)
        return 3

    assert await notifying_systemd(main()) == 3


def test_a_signal_at_the_end_finds_no_closed_socket(monkeypatch: pytest.MonkeyPatch) -> None:
    sockets: list[int] = []
    close = asyncio.Runner.close

    def watched_close(runner: asyncio.Runner) -> None:
        sockets.append(signal.set_wakeup_fd(-1))
        close(runner)

    monkeypatch.setattr(asyncio.Runner, "close", watched_close)
    run(asyncio.sleep(0))
    assert sockets == [-1]
