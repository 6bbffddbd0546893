"""Programs on PATH that only record their arguments, because no board is flashed in a test."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest


class FakeProgram:
    """A program that records its arguments, prints a text and ends with an exit code."""

    def __init__(self, folder: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
        self._calls = folder / f"{name}.calls"
        self._path = folder / name
        monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
        self.behave()

    def behave(self, *, code: int = 0, prints: str = "", then: str = "") -> None:
        """Set its behavior from now on; `then` is Python code that may use `arguments`."""
        self._path.write_text(
            f"#!{sys.executable}\nimport json, pathlib, sys\narguments = sys.argv[1:]\n"
            f"open({str(self._calls)!r}, 'a').write(json.dumps(arguments) + '\\n')\n"
            f"print({prints!r})\n{then}\nsys.exit({code})\n"
        )
        self._path.chmod(0o755)

    @property
    def calls(self) -> list[list[str]]:
        """The arguments of each call."""
        if not self._calls.exists():
            return []
        return [json.loads(line) for line in self._calls.read_text().splitlines()]
