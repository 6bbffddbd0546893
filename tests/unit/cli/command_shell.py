"""Runs commands as users do, with a master and nodes in another thread."""

from __future__ import annotations

import asyncio
import io
import json
import re
import threading
import time
from collections.abc import Callable, Coroutine
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, TypeVar

import pytest

from rostether.cli.main import main
from rostether.msgdef.registry import Registry
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import Ros1Graph, join_ros1
from rostether.serde.store import TypeStore

T = TypeVar("T")

STORE = TypeStore(Registry())


class GraphThread:
    """An event loop in another thread."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()

    def do(self, work: Coroutine[Any, Any, T]) -> T:
        """Run a coroutine in the thread and wait for its result."""
        return self.begin(work).result(60)

    def begin(self, work: Coroutine[Any, Any, T]) -> Future[T]:
        """Start a coroutine in the thread."""
        return asyncio.run_coroutine_threadsafe(work, self._loop)

    def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until a condition is true."""
        deadline_s = time.monotonic() + 60
        while not condition():
            assert time.monotonic() < deadline_s, "the condition did not become true"
            time.sleep(0.002)

    def close(self) -> None:
        """End the loop and its thread."""
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(60)
        self._loop.close()


class LiveGraph(GraphThread):
    """A master and nodes, which run in the thread."""

    def __init__(self) -> None:
        super().__init__()
        self.is_closed = False
        self.master = self.do(MasterServer.start(port=0))
        self._nodes: list[Ros1Graph] = []

    @property
    def uri(self) -> str:
        return self.master.uri

    def node(self, name: str) -> Ros1Graph:
        """Start a node."""
        graph = self.do(join_ros1(name, environment=RosEnvironment.read({}).with_master(self.uri)))
        self._nodes.append(graph)
        return graph

    def close(self) -> None:
        """End the nodes, the master and the thread."""
        self.is_closed = True
        for node in self._nodes:
            self.do(node.close())
        self.do(self.master.close())
        super().close()


@dataclass(frozen=True)
class Result:
    """How a command ended."""

    code: int
    out: str
    err: str

    @property
    def records(self) -> list[dict[str, Any]]:
        """What `--json` printed."""
        return [json.loads(line) for line in self.out.splitlines()]


class Shell:
    """Runs commands; `output` and `failure` also check how they end."""

    def __init__(self, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
        self._capsys = capsys
        self._monkeypatch = monkeypatch

    def __call__(self, *arguments: str, stdin: str = "") -> Result:
        self._monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(stdin.encode()), "utf-8"))
        self._capsys.readouterr()
        code = main(arguments)
        captured = self._capsys.readouterr()
        return Result(code, captured.out, captured.err)

    def output(self, *arguments: str, stdin: str = "") -> str:
        """Run a command that must succeed without a line on stderr; return its output."""
        result = self(*arguments, stdin=stdin)
        assert (result.code, result.err) == (0, ""), result
        return result.out

    def observed(self, pattern: str, *arguments: str, before: Callable[[], object] = lambda: None) -> str:
        """Run a command that listens for a while; run it again for longer until its output matches a pattern.

        `before` is called before each try.
        """
        result = None
        for seconds in ("2", "20", "60"):
            before()
            result = self(*arguments, "--duration", seconds)
            if re.search(pattern, result.out, re.DOTALL):
                break
        assert result is not None
        assert (result.code, result.err) == (0, ""), result
        return result.out

    def failure(self, *arguments: str, code: int = 1, stdin: str = "") -> str:
        """Run a command that must fail with one error line at the end; return that line."""
        result = self(*arguments, stdin=stdin)
        assert result.code == code, result
        line = result.err.splitlines()[-1]
        assert line.startswith("rostether: error: "), result
        return line.removeprefix("rostether: error: ")
