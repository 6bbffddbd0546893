"""Starts and examines processes: their CPU seconds and memory, the connections of a node."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
import xmlrpc.client
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

from interop.ros1_peers import free_port, ros_environment, roscpp_peer

REPOSITORY = Path(__file__).parent.parent
TICK_S = 1 / os.sysconf("SC_CLK_TCK")


def wait_until(condition: Callable[[], bool], what: str, timeout_s: float = 20.0) -> None:
    """Poll until a condition holds; at the time limit, fail with the name of the condition, `what`."""
    deadline = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > deadline:
            raise RuntimeError(f"gave up waiting for {what}")
        time.sleep(0.005)


def cpu_s(pid: int) -> float:
    """Return user and system seconds that a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) * TICK_S


def resident_mb(pid: int | str) -> float:
    """Return the resident memory of a process in MB."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    return 0.0


class Bench:
    """Our master or Debian's, and the processes of one measurement; all end with the block."""

    def __init__(self, *, roscore: bool = False) -> None:
        self._roscore = roscore
        self.port = free_port()
        self.master_uri = f"http://localhost:{self.port}"
        self._stack = ExitStack()
        self._home = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="rostether-bench-")))

    def __enter__(self) -> Bench:
        if self._roscore:
            environment = ros_environment(self.master_uri, self._home)
            self.start("rosmaster", "--core", "-p", str(self.port), env=environment)
        else:
            self.rostether("core", "--port", str(self.port))
        wait_until(self._master_answers, "the master")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()

    def _master_answers(self) -> bool:
        try:
            self.master.getPid("/bench")
        except OSError:
            return False
        return True

    @property
    def master(self) -> Any:
        """A new client of the master, because its connection does not survive an error."""
        return xmlrpc.client.ServerProxy(self.master_uri)

    def start(self, *command: str, env: dict[str, str] | None = None) -> subprocess.Popen[str]:
        """Start a process; its output is read and its input is written in lines."""
        process = subprocess.Popen(
            command,
            cwd=REPOSITORY,
            env=env,
            text=True,
            bufsize=1,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._stack.callback(self._end, process)
        return process

    @staticmethod
    def _end(process: subprocess.Popen[str]) -> None:
        if process.poll() is None:
            process.terminate()
        try:
            process.wait(5)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                stream.close()

    def rostether(self, *arguments: str) -> subprocess.Popen[str]:
        """Start one of our commands with this master; its log is discarded."""
        environment = dict(os.environ, ROS_MASTER_URI=self.master_uri)
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        process = subprocess.Popen(
            [sys.executable, "-m", "rostether", *arguments],
            # An empty folder: in a workspace, a board's first message waits for the search of its packages.
            cwd=self._home,
            env=environment,
            text=True,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self._stack.callback(self._end, process)
        return process

    def module(self, name: str, *arguments: str) -> subprocess.Popen[str]:
        """Start one of the benchmarks' own programs."""
        return self.start(sys.executable, "-m", f"benchmarks.{name}", *arguments)

    def roscpp(self, role: str, *arguments: str) -> subprocess.Popen[str]:
        """Start the compiled roscpp peer."""
        return self.start(
            str(roscpp_peer()), role, *arguments, env=ros_environment(self.master_uri, self._home)
        )

    def wait_for_publisher(self, topic: str) -> str:
        """Wait until a node publishes a topic; return its name."""
        found: list[str] = []

        def published() -> bool:
            publishers = dict(self.master.getSystemState("/bench")[2][0])
            found.extend(publishers.get(topic, []))
            return bool(found)

        wait_until(published, f"a publisher of {topic}")
        return found[0]

    def wait_for_connection(self, node: str, topic: str) -> None:
        """Wait until a node has a TCPROS connection on a topic (its getBusInfo names it)."""
        uri = self.master.lookupNode("/bench", node)[2]

        def connected() -> bool:
            slave_api: Any = xmlrpc.client.ServerProxy(uri)
            return any(row[4] == topic for row in slave_api.getBusInfo("/bench")[2])

        wait_until(connected, f"a connection of {node} on {topic}")


def output(process: subprocess.Popen[str]) -> list[str]:
    """Wait until a process has printed its figures; return the words of its last line."""
    assert process.stdout is not None
    lines = process.stdout.read().split("\n")
    words = [line.split() for line in lines if line.strip()]
    if not words:
        raise RuntimeError("a peer ended without its figures")
    return words[-1]


def first_line(process: subprocess.Popen[str]) -> list[str]:
    """Return the words of the next line that a process prints."""
    assert process.stdout is not None
    return process.stdout.readline().split()


def say(process: subprocess.Popen[str], line: str = "go") -> None:
    """Write a line to a process."""
    assert process.stdin is not None
    process.stdin.write(line + "\n")
    process.stdin.flush()
