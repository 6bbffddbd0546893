"""The shape of the tree: file lengths, names that say something, and that a light start stays light."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "src" / "rostether"
MODULES = sorted(PACKAGE.rglob("*.py"))
LONGEST_FILE_LINES = 330
NAMES_THAT_SAY_NOTHING = {"util", "utils", "helper", "helpers", "manager", "common", "misc", "base"}
# `core` is the verb that every ROS user knows, and modules are called as rospy's programs import them.
ALLOWED = {PACKAGE / "cli" / "bridge" / "core.py", *(PACKAGE / "rospy_facade" / "modules").rglob("*.py")}
HEAVY = {
    "numpy",
    "rosbags",
    "rich",
    "serialx",
    "zeroconf",
    "xml.dom",
    "http.client",
    "email",
    "multiprocessing",
}


@pytest.mark.parametrize("module", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_one_concept_a_file(module: Path) -> None:
    assert len(module.read_text().splitlines()) <= LONGEST_FILE_LINES


@pytest.mark.parametrize("module", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_error_passes_through_except_star(module: Path) -> None:
    """Python 3.11.2, which Debian 12 has, wraps what is raised in `except*` into a group of its own."""
    assert not any(isinstance(node, ast.TryStar) for node in ast.walk(ast.parse(module.read_text())))


def test_names_say_what_is_inside() -> None:
    parts = {(path, part) for path in MODULES for part in path.relative_to(PACKAGE).with_suffix("").parts}
    vague = {path for path, part in parts if part in NAMES_THAT_SAY_NOTHING or part == "core"}
    assert vague <= ALLOWED


@pytest.mark.parametrize("module", ["rostether", "rostether.cli.main", "rostether.bridge.supervisor"])
def test_import_stays_light(module: str) -> None:
    code = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not HEAVY & set(loaded.stdout.split())


def test_no_transport_writes_lines() -> None:
    # Transport.writelines of Python 3.12.0 to 3.12.8, 3.13.0 and 3.13.1 grows without limit (CVE-2024-12254).
    assert [path for path in MODULES if ".writelines(" in path.read_text()] == []
