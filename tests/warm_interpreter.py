"""An interpreter that has imported libraries and runs each requested program in a fork of itself.

`warm_start` starts it, under the Python of the tests or Debian's, and describes the requests.
"""

from __future__ import annotations

import _thread
import atexit
import builtins
import ctypes
import gc
import importlib
import importlib.machinery
import io
import json
import os
import runpy
import signal
import socket
import sys
import time
import types
from pathlib import Path
from typing import Any

# clone(2); each architecture has its own number.
_CLONE = {"x86_64": 56, "aarch64": 220}
_CLONE_PARENT = 0x8000
_NAME_BYTES = 15


def fork_sibling() -> int:
    """Fork as `os.fork` does, but the child's parent is this process's parent, which can wait for it."""
    # PyDLL keeps the interpreter locked, so parent and child agree on its state.
    python = ctypes.PyDLL(None)
    python.PyOS_BeforeFork()
    pid: int = python.syscall(_CLONE[os.uname().machine], _CLONE_PARENT | signal.SIGCHLD, 0, 0, 0, 0)
    if pid == 0:
        python.PyOS_AfterFork_Child()
    else:
        python.PyOS_AfterFork_Parent()
    return pid


def receive(control: socket.socket) -> tuple[dict[str, Any], list[int]]:
    """Return a request and its standard input, output and error. At the end of the tests, exit."""
    header, fds, _, _ = socket.recv_fds(control, 4, 3)
    if not header:
        os._exit(0)
    missing = int.from_bytes(header, "big")
    parts = []
    while missing:
        part = control.recv(missing)
        parts.append(part)
        missing -= len(part)
    return json.loads(b"".join(parts)), fds


class Ending:
    """The end of a program, without changes of the memory that it shares with other programs.

    Python's finalization clears all modules and frees the interpreter's memory, which copies most of it.
    """

    def __init__(self) -> None:
        self.libraries: dict[str, types.ModuleType] = {}
        self.code: int | None = None
        # The first registered handler runs last.
        atexit.register(self._end)

    def _end(self) -> None:
        # A reference that is never released.
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self.libraries))
        # After an error or with threads, Python ends the program: it reports the error, and stops the threads
        # while it clears what they use.
        if self.code is not None and _thread._count() == 0:
            self._end_program(self.code)
        for name in self.libraries:
            sys.modules.pop(name, None)

    def _end_program(self, code: int) -> None:
        vars(sys.modules["__main__"]).clear()
        extensions = tuple(importlib.machinery.EXTENSION_SUFFIXES)
        has_extensions = False
        # The last modules of the dictionary, which are the program's, first.
        name, module = sys.modules.popitem()
        while name not in self.libraries:
            has_extensions |= str(getattr(module, "__file__", "")).endswith(extensions)
            name, module = sys.modules.popitem()
        del module
        gc.collect()
        try:
            sys.stdout.flush()
            sys.stderr.flush()
        except (AttributeError, OSError, ValueError):
            # Python's own finalization reports the error.
            return
        if has_extensions or len(os.listdir("/proc/self/task")) > 1:  # noqa: PTH208 - imports nothing
            ctypes.pythonapi.exit(code)
        # The exit handlers of libraries such as OpenSSL only free memory. Threads belong
        # to a library that may still have work.
        ctypes.pythonapi.fflush(None)
        os._exit(code)


def end_servers_when_closed() -> None:
    """End rospy's XML-RPC servers when they are closed.

    Those of Debian poll their closed sockets without a pause until the process ends, after 0.1 to 0.7 s.
    """
    server: Any = sys.modules["rosgraph.xmlrpc"].ThreadingXMLRPCServer
    close = server.server_close

    def server_close(self: Any) -> None:
        self._BaseServer__shutdown_request = True
        close(self)

    server.server_close = server_close


def enter_namespace(file: str) -> None:
    """Enter a namespace, like `nsenter`."""
    fd = os.open(file, os.O_RDONLY)
    if ctypes.CDLL(None, use_errno=True).setns(fd, 0) != 0:
        raise OSError(ctypes.get_errno(), f"cannot enter {file}")
    os.close(fd)


def set_up_process(request: dict[str, Any], fds: list[int]) -> None:
    """Give this new process the state that the program would have at its start."""
    if request["is_leader"]:
        os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number, fd in enumerate(fds):
        os.dup2(fd, number)
    for fd in fds:
        os.close(fd)
    for file in request["namespaces"]:
        enter_namespace(file)
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    time.tzset()
    # Some functions have the list object as their default argument.
    sys.argv[:] = request["arguments"]
    sys.orig_argv = list(request["command"])
    _set_command_line(request["command"], request["name"])
    _open_streams(request["is_unbuffered"])
    sys.path[:0] = request["path"]
    if "PYTHONPATH" in os.environ:
        _run_site_customization()
    if "rospy.names" in sys.modules:
        # Reads the command line and the environment.
        importlib.reload(sys.modules["rospy.names"])


def _set_command_line(command: list[str], name: str) -> None:
    """Show the program's command line and name in /proc; this interpreter's own line is longer."""
    first, end = (int(word) for word in Path("/proc/self/stat").read_text().rpartition(")")[2].split()[45:47])
    line = b"\0".join(map(os.fsencode, command))[: end - first - 1]
    ctypes.memmove(first, line.ljust(end - first, b"\0"), end - first)
    Path("/proc/self/comm").write_bytes(os.fsencode(name)[:_NAME_BYTES])


def _open_streams(is_unbuffered: bool) -> None:
    for name, fd, mode in (("stdin", 0, "rb"), ("stdout", 1, "wb"), ("stderr", 2, "wb")):
        old = getattr(sys, name)
        is_raw = is_unbuffered and fd != 0
        raw = open(fd, mode, 0 if is_raw else -1, closefd=False)  # noqa: SIM115 - the program closes it
        stream = io.TextIOWrapper(
            raw,
            old.encoding,
            old.errors,
            newline="\n",
            line_buffering=not is_unbuffered and (fd == 2 or raw.isatty()),
            write_through=is_unbuffered,
        )
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def _run_site_customization() -> None:
    """Import `sitecustomize`, like `site`."""
    sys.modules.pop("sitecustomize", None)
    importlib.invalidate_caches()
    try:
        importlib.import_module("sitecustomize")
    except ModuleNotFoundError as error:
        if error.name != "sitecustomize":
            raise


def run(request: dict[str, Any]) -> None:
    """Run the program as the main module."""
    main = types.ModuleType("__main__")
    main.__dict__.update(__builtins__=builtins, __annotations__={})
    sys.modules["__main__"] = main
    kind, program = request["program"]
    if kind == "module":
        runpy._run_module_as_main(program)  # type: ignore[attr-defined]
        return
    if kind == "file":
        main.__dict__.update(__file__=program, __cached__=None)
        source: bytes | str = Path(program).read_bytes()
    else:
        source = program
    exec(compile(source, program if kind == "file" else "<string>", "exec", dont_inherit=True), main.__dict__)


def next_request(control: socket.socket) -> dict[str, Any]:
    """Start a child for each request; return the request in the child."""
    while True:
        request, fds = receive(control)
        pid = fork_sibling()
        if pid == 0:
            control.close()
            set_up_process(request, fds)
            return request
        for fd in fds:
            os.close(fd)
        control.sendall(pid.to_bytes(4, "big", signed=True))


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _ending = Ending()
    for _name in sys.argv[2].split(","):
        importlib.import_module(_name)
    if "rosgraph.xmlrpc" in sys.modules:
        end_servers_when_closed()
    # Without this, collecting garbage would copy the memory that children share.
    _ending.libraries.update(sys.modules)
    del _ending.libraries["__main__"]
    gc.collect()
    gc.freeze()
    del sys.path[0]
    # The program's PYTHONPATH may differ.
    sys.path = [
        folder for folder in sys.path if folder not in os.environ.get("PYTHONPATH", "").split(os.pathsep)
    ]
    _request = next_request(socket.socket(fileno=int(sys.argv[1])))
    try:
        run(_request)
        _ending.code = 0
    except SystemExit as _exit:
        if _exit.code is None or isinstance(_exit.code, int):
            _ending.code = _exit.code or 0
        raise
