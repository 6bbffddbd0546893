"""A program that starts as a fork of an interpreter has the same environment as with a start of Python."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import warm_start
import warm_worker

pytestmark = pytest.mark.skipif(not warm_start.IS_SUPPORTED, reason="no forks of an interpreter here")

PRINTS_ITS_ENVIRONMENT = """
import json, os, signal, sys
import helper
# Set by Python itself, and by the wheels of rclpy.
OWN = ("LC_CTYPE", "LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE")
def stream(name):
    file = getattr(sys, name)
    kinds = [type(file.buffer).__name__, file is getattr(sys, f"__{name}__")]
    return [file.encoding, file.errors, file.line_buffering, file.write_through, *kinds]
def read(name):
    with open(f"/proc/self/{name}") as file:
        return file.read().rstrip(chr(0))
print(json.dumps({
    "argv": sys.argv, "orig_argv": sys.orig_argv, "path": sys.path, "executable": sys.executable,
    "streams": [stream(name) for name in ("stdin", "stdout", "stderr")], "read": sys.stdin.read(),
    "environment": {name: value for name, value in os.environ.items() if name not in OWN},
    "folder": os.getcwd(), "leads": os.getsid(0) == os.getpid(), "parent": os.getppid(),
    "files": sorted(os.listdir("/proc/self/fd")), "cmdline": read("cmdline"),
    "signals": [repr(signal.getsignal(number)) for number in (1, 2, 3, 13, 15)],
    "comm": read("comm"),
    "names": sorted(globals()), "file": globals().get("__file__"), "helper": helper.__file__,
}))
"""
HELPER = "import sitecustomize\n"
ARGUMENTS = ["one", "--two", "drei: ä"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a script, a module that it imports, and a sitecustomize, as in a folder of PYTHONPATH."""
    (tmp_path / "helper.py").write_text(HELPER)
    (tmp_path / "sitecustomize.py").write_text("")
    for name, python in (("show", sys.executable), ("show_of_env", "/usr/bin/env python")):
        script = tmp_path / f"{name}_its_long_name_in_proc"
        script.write_text(f"#!{python}\n{PRINTS_ITS_ENVIRONMENT}")
        script.chmod(0o755)
    return tmp_path


def run(*command: str, **options: Any) -> Any:
    completed = subprocess.run(
        [*command, *ARGUMENTS], capture_output=True, text=True, input="a line\n", check=False, **options
    )
    assert (completed.returncode, completed.stderr) == (0, "")
    return json.loads(completed.stdout)


@pytest.mark.parametrize("is_leader", [False, True])
@pytest.mark.parametrize("variables", [{}, {"PYTHONUNBUFFERED": "1", "LANG": "C.UTF-8"}], ids=len)
@pytest.mark.parametrize("kind", ["text", "file", "script", "env", "unbuffered"])
def test_a_program_has_the_environment_of_a_cold_start(
    folder: Path, kind: str, variables: dict[str, str], is_leader: bool, request: pytest.FixtureRequest
) -> None:
    script = folder / "show_its_long_name_in_proc"
    command = {
        "text": [sys.executable, "-c", PRINTS_ITS_ENVIRONMENT],
        "file": [sys.executable, script.name],
        "script": [str(script)],
        "env": [str(folder / "show_of_env_its_long_name_in_proc")],
        "unbuffered": [sys.executable, "-P", "-u", "-c", PRINTS_ITS_ENVIRONMENT],
    }[kind]
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(folder), **variables}
    options = {"cwd": folder, "env": environment, "start_new_session": is_leader}
    warm = run(*command, **options)
    request.getfixturevalue("cold_start")
    cold = run(*command, **options)
    assert {name: (warm[name], value) for name, value in cold.items() if warm[name] != value} == {}


@pytest.mark.parametrize(
    "python", [sys.executable, pytest.param(warm_start.DEBIAN_PYTHON, marks=pytest.mark.ros1)]
)
def test_libraries_are_imported_before_the_start(python: str) -> None:
    code = "import sys; print(*sys.modules)"
    shown = subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout
    expected = "rostether.cli.main" if python == sys.executable else "genpy"
    assert expected in shown.split()


@pytest.mark.parametrize(
    ("code", "status", "error"),
    [
        ("", 0, ""),
        ("raise SystemExit(3)", 3, ""),
        ("raise SystemExit('wrong')", 1, "wrong\n"),
        ("1 / 0", 1, "ZeroDivisionError: division by zero\n"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGINT)", -signal.SIGINT, "KeyboardInterrupt\n"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGTERM)", -signal.SIGTERM, ""),
        ("import atexit; atexit.register(print, 'left'); print('end', end=' ')", 0, ""),
        (
            "import threading; threading.Timer(0.1, print, ['late']).start()",
            0,
            "",
        ),
        ("class A:\n def __del__(self): raise ValueError('lost')\na = A()", 0, "ValueError: lost\n"),
        ("import ctypes; ctypes.CDLL(None).puts(b'buffered by C')", 0, ""),
        # Like an exit handler of the extension.
        (
            "import ctypes, lz4.block\nc = ctypes.CDLL(None)\nc.__cxa_atexit(c.abort, 0, 0)",
            -signal.SIGABRT,
            "",
        ),
    ],
)
def test_a_program_ends_as_after_a_cold_start(
    code: str, status: int, error: str, request: pytest.FixtureRequest
) -> None:
    command = [sys.executable, "-c", code]
    warm = subprocess.run(command, capture_output=True, text=True, check=False)
    assert warm.returncode == status
    assert warm.stderr.endswith(error)
    assert bool(warm.stderr) == bool(error)
    request.getfixturevalue("cold_start")
    assert subprocess.run(command, capture_output=True, text=True, check=False).stdout == warm.stdout


@pytest.mark.ros1
def test_a_closed_server_of_rospy_ends() -> None:
    code = """
import threading, time
from rosgraph.xmlrpc import XmlRpcHandler, XmlRpcNode
node = XmlRpcNode(0, XmlRpcHandler())
thread = threading.Thread(target=node.run, daemon=True)
thread.start()
while node.uri is None:
    time.sleep(0.01)
node.shutdown("")
thread.join(10)
print(thread.is_alive())
"""
    command = [warm_start.DEBIAN_PYTHON, "-c", code]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "False\n"


async def test_asyncio_starts_a_program() -> None:
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "rostether", "--version", stdout=asyncio.subprocess.PIPE
    )
    output, _ = await process.communicate()
    assert process.returncode == 0
    assert output.startswith(b"rostether, version ")


def test_test_processes_start_with_collected_tests(request: pytest.FixtureRequest) -> None:
    is_forked = "PYTEST_XDIST_WORKER" in os.environ and not request.config.getoption("cov_source")
    collected = getattr(warm_worker, "COLLECTED", None)
    assert (collected is not None and collected.session is request.session) == is_forked
