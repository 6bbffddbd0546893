from __future__ import annotations

import logging
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from rostether.msgdef.definition_files import PackageFiles, find_definitions
from unit.cli.command_shell import LiveGraph, Shell


@pytest.fixture(autouse=True)
def no_router(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep demos that run at the same time away from this machine's zenoh router, which they would share."""
    monkeypatch.setenv("ZENOH_CONFIG_OVERRIDE", 'connect/endpoints=["tcp/127.0.0.1:9"]')


@pytest.fixture
def shell(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Shell:
    """Commands, in an empty folder and an environment without ROS; no master answers at its URI."""
    monkeypatch.chdir(tmp_path)
    for name in ("ROS_NAMESPACE", "ROS_IP", "ROS_HOSTNAME", "ROS_PACKAGE_PATH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")
    # What nodes in the test's process log is not output of the command.
    for name in ("rostether", "asyncio"):
        monkeypatch.setattr(logging.getLogger(name), "handlers", [])
    for name in ("shell.running", "bridge.serving"):
        monkeypatch.setattr(f"rostether.cli.{name}.show_library_logs", lambda *_: None)
    return Shell(capsys, monkeypatch)


@pytest.fixture
def searching_threads(monkeypatch: pytest.MonkeyPatch) -> list[threading.Thread]:
    """The threads that have searched folders for definitions."""
    threads: list[threading.Thread] = []

    def note(*folders: Iterable[Path]) -> dict[str, PackageFiles]:
        threads.append(threading.current_thread())
        return find_definitions(*folders)

    monkeypatch.setattr("rostether.msgdef.registry.find_definitions", note)
    return threads


@pytest.fixture
def graph(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> Iterator[LiveGraph]:
    """A master, whose URI is in the commands' environment."""
    live = LiveGraph()
    monkeypatch.setenv("ROS_MASTER_URI", live.uri)
    try:
        yield live
    finally:
        live.close()
