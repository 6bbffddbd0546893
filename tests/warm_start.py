"""Starts Python programs without the start of the interpreter and the imports of its libraries.

Most of the time of a short command is its start, and the tests start thousands. So `subprocess` and `asyncio`
start `rostether` and Debian's Python programs by a fork of an interpreter with the libraries imported
(`warm_interpreter`). Everything else is separate: process, environment, folder, streams, signals.
The fixture `cold_start` is for tests of the start itself.
"""

from __future__ import annotations

import contextlib
import inspect
import itertools
import json
import os
import platform
import shutil
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import warm_worker

DEBIAN_PYTHON = "/usr/bin/python3"
# Libraries that many programs import; they start no threads.
_LIBRARIES = {
    DEBIAN_PYTHON: "rospy,rosbag,rosmsg,rosnode,rosservice,rostopic,geometry_msgs.msg,nav_msgs.msg,"
    "sensor_msgs.msg,std_srvs.srv,argparse,logging.config",
    sys.executable: "rostether.cli.main,rostether.cli.bridge.serve,rostether.cli.topic.ros1_echo,"
    "rostether.cli.launch.loaded_launch,rostether.launch.runner,rostether.cli.dashboard.served,rostether.bridge.supervisor,"
    "rostether.ros1.master.server,rostether.ros1.node.node,rostether.transports.serial,"
    "rostether.gateways.websocket.server,rostether.simulation.simavr.simulated_board,"
    "rostether.firmware.build,rostether.graph.typed_graph,rostether.ros2.zenoh.session,"
    "rostether.recording.recorder,rostether.cli.role.group,rostether.cli.demo.demo,rostether.cli.board.opencr,"
    "rostether.cli.topic.ros1_listing,rostether.serde.yaml_print,rostether.gateways.client_json,"
    "rostether.cli.bridge.doctor,concurrent.futures.thread,sqlite3,uuid,resource,stringprep,decimal",
}
_INTERPRETER = Path(__file__).with_name("warm_interpreter.py")
# The interpreter's command line is at least this long, so that a program's command line can replace it.
_COMMAND_LINE_BYTES = 4096
# Environment variables that change an interpreter's start; those of _KNOWN are followed.
_KNOWN = ("PYTHONPATH", "PYTHONUNBUFFERED", "PYTHONDONTWRITEBYTECODE")
_LOCALE = ("LC_ALL", "LC_CTYPE", "LANG")
# The environment variable by which `children` finds the processes of a test process.
MARK = "STARTED_BY_TESTS"
IS_SUPPORTED = sys.platform == "linux" and platform.machine() in ("x86_64", "aarch64")

_execute_child = subprocess.Popen._execute_child  # type: ignore[attr-defined]
_SIGNATURE = inspect.signature(_execute_child)


class WarmInterpreter:
    """One running interpreter."""

    def __init__(self, python: str, libraries: str, variables: Mapping[str, str]) -> None:
        self._control, child_socket = socket.socketpair()
        self._lock = threading.Lock()
        environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        if python == sys.executable and "PYTHONPATH" in os.environ:
            # The libraries of the tests.
            environment["PYTHONPATH"] = os.environ["PYTHONPATH"]
        command = [python, str(_INTERPRETER), str(child_socket.fileno()), libraries]
        self._process = subprocess.Popen(
            [*command, "-" * _COMMAND_LINE_BYTES],
            pass_fds=[child_socket.fileno()],
            env={**environment, **_UTF8, **variables},
        )
        child_socket.close()

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def start(self, request: Mapping[str, Any], fds: Sequence[int]) -> int:
        """Start a program; return its process id, or 0 if the interpreter has ended.

        The program is a child of this process.
        """
        data = json.dumps(request).encode()
        with self._lock, contextlib.suppress(ConnectionError):
            socket.send_fds(self._control, [len(data).to_bytes(4, "big")], fds)
            self._control.sendall(data)
            return int.from_bytes(self._control.recv(4), "big", signed=True)
        return 0

    def close(self) -> None:
        """End it; the programs continue."""
        self._control.close()
        self._process.kill()
        self._process.wait()


_UTF8 = {"LC_ALL": "C.UTF-8"}
_interpreters: dict[str, WarmInterpreter] = {}
_is_enabled = False
_has_warm_workers = False
_has_started = True


def has_started_programs() -> bool:
    """Return whether a program was started since the last call; if not, no search in /proc is needed."""
    global _has_started
    had_started, _has_started = _has_started, subprocess.Popen._execute_child is not _start  # type: ignore[attr-defined]
    return had_started


def _record_start() -> None:
    global _has_started
    _has_started = True


# Also forks by `pty` and `os`.
if IS_SUPPORTED:
    os.register_at_fork(before=_record_start)


def interpreter_pids() -> set[int]:
    """Return the ids of the interpreters of this process."""
    return {each.pid for each in _interpreters.values()}


def pytest_sessionstart(session: pytest.Session) -> None:
    """Start programs this way from now on.

    The controller of pytest-xdist starts its test processes in this way. With coverage, they start cold,
    because coverage would miss the lines that run at import.
    """
    global _is_enabled, _has_warm_workers
    config = session.config
    is_controller = bool(config.getoption("numprocesses", None)) and not hasattr(config, "workerinput")
    if not IS_SUPPORTED or (is_controller and config.getoption("cov_source", None)):
        return
    if is_controller:
        _interpreters[sys.executable] = WarmInterpreter(
            sys.executable, "warm_worker", warm_worker.variables(config)
        )
    subprocess.Popen._execute_child = _start  # type: ignore[attr-defined]
    _is_enabled, _has_warm_workers = True, is_controller


def pytest_xdist_getremotemodule() -> ModuleType | None:
    """Return the module that runs in a test process that starts with the collected tests."""
    return warm_worker if _has_warm_workers else None


def pytest_unconfigure() -> None:
    """End the interpreters."""
    subprocess.Popen._execute_child = _execute_child  # type: ignore[attr-defined]
    while _interpreters:
        _interpreters.popitem()[1].close()


@pytest.fixture
def cold_start() -> Iterator[None]:
    """Start programs without preloaded imports."""
    global _is_enabled
    was_enabled, _is_enabled = _is_enabled, False
    yield
    _is_enabled = was_enabled


def _start(process: subprocess.Popen[Any], *arguments: Any, **options: Any) -> None:
    global _is_enabled, _has_warm_workers
    _record_start()
    call = _SIGNATURE.bind(process, *arguments, **options).arguments
    found = _request(call) if _is_enabled else None
    if found is None:
        _execute_child(process, *arguments, **options)
        return
    python, request = found
    descriptors = [
        call[name] if call[name] != -1 else fd for fd, name in enumerate(("p2cread", "c2pwrite", "errwrite"))
    ]
    if python not in _interpreters:
        _interpreters[python] = WarmInterpreter(python, _LIBRARIES[python], {})
    process.pid = _interpreters[python].start(request, descriptors)
    if process.pid == 0:
        _is_enabled = _has_warm_workers = False
        _execute_child(process, *arguments, **options)
        return
    process._child_created = True  # type: ignore[attr-defined]
    pipes = ("p2cread", "p2cwrite", "c2pread", "c2pwrite", "errread", "errwrite")
    process._close_pipe_fds(*(call[name] for name in pipes))  # type: ignore[attr-defined]


def _request(call: Mapping[str, Any]) -> tuple[str, dict[str, Any]] | None:
    """Return the Python and the request for a program, or None if it needs a normal start."""
    if not _is_plain(call):
        return None
    environment = dict(os.environ if call["env"] is None else call["env"])
    if environment.get(MARK) != os.environ.get(MARK):
        # /proc shows the first environment of a fork, which is the interpreter's.
        return None
    folder = Path.cwd() / (call["cwd"] or "")
    namespaces, command = _namespaces([os.fspath(word) for word in call["args"]])
    program = _program(command, environment, folder)
    if program is None or not _can_apply(environment):
        return None
    added = [part for part in environment.get("PYTHONPATH", "").split(os.pathsep) if part]
    return program.python, {
        "program": program.what,
        "arguments": program.arguments,
        "command": program.command,
        "name": program.name,
        "environment": environment,
        "folder": str(folder),
        "namespaces": namespaces,
        "path": [*program.path, *added],
        "is_leader": call["start_new_session"],
        "is_unbuffered": program.is_unbuffered or bool(environment.get("PYTHONUNBUFFERED")),
    }


def _namespaces(command: list[str]) -> tuple[list[str], list[str]]:
    """Return the files of the namespaces that `nsenter` would enter, and the command that it would run.

    `interop.machines` begins commands with `nsenter`.
    """
    files: list[str] = []
    while command[0] == "nsenter":
        options = list(
            itertools.takewhile(lambda word: word.startswith("--") and word != "--target", command[1:])
        )
        command = command[1 + len(options) :]
        files += [option.removeprefix("--net=") for option in options if option.startswith("--net=")]
        if command[0] == "--target":
            kinds = (("--user", "user"), ("--net", "net"), ("--mount", "mnt"))
            files += [f"/proc/{command[1]}/ns/{kind}" for option, kind in kinds if option in options]
            command = command[2:]
    return files, command


def _is_plain(call: Mapping[str, Any]) -> bool:
    """Return whether a start has only arguments, environment, folder, streams and a session."""
    return (
        not isinstance(call["args"], str | bytes | os.PathLike)
        and not (call["executable"] or call["shell"] or call["preexec_fn"] or call["pass_fds"])
        and all(call[name] is None for name in ("uid", "gid", "gids"))
        and call["umask"] == call["process_group"] == -1
    )


def _can_apply(environment: Mapping[str, str]) -> bool:
    """Return whether a running interpreter can apply the settings of these variables."""
    unknown = [name for name in environment if name.startswith("PYTHON") and name not in _KNOWN]
    locale = next((value for name in _LOCALE if (value := environment.get(name))), "C")
    return not unknown and locale in ("C", "C.UTF-8", "POSIX")


@dataclass(frozen=True)
class _Program:
    """A Python program: `what` is the kind (module, text, file) and the module, text or path."""

    python: str
    what: tuple[str, str]
    path: list[str]
    arguments: list[str]
    command: list[str]
    name: str
    is_unbuffered: bool = False


def _program(command: list[str], environment: Mapping[str, str], folder: Path) -> _Program | None:
    found = shutil.which(command[0], path=environment.get("PATH", os.defpath))
    if found is None:
        return None
    if found in _LIBRARIES:
        return _python_program(found, command, folder)
    with Path(found).open("rb") as script:
        first_line = script.readline(256).decode(errors="replace")
    path = [str(Path(found).resolve().parent)]
    arguments = [found, *command[1:]]
    what = ("file", found)
    match first_line.removeprefix("#!").split() if first_line.startswith("#!") else []:
        case [python] if python in _LIBRARIES:
            return _Program(python, what, path, arguments, [python, *arguments], Path(found).name)
        case ["/usr/bin/env", name]:
            python = shutil.which(name, path=environment.get("PATH", os.defpath)) or ""
            if python in _LIBRARIES:
                return _Program(python, what, path, arguments, [name, *arguments], name)
    return None


def _python_program(python: str, command: list[str], folder: Path) -> _Program | None:
    options = list(itertools.takewhile(("-P", "-u").__contains__, command[1:]))
    remaining = command[1 + len(options) :]
    match remaining:
        case ["-m", "rostether", *rest]:
            what, path, arguments = ("module", "rostether"), str(folder), ["-m", *rest]
        case ["-c", text, *rest]:
            what, path, arguments = ("text", text), "", ["-c", *rest]
        case [file, *_] if not file.startswith("-"):
            script = folder / file
            what, path, arguments = ("file", str(script)), str(script.resolve().parent), remaining
        case _:
            return None
    added = [] if "-P" in options else [path]
    return _Program(python, what, added, arguments, command, Path(command[0]).name, "-u" in options)
