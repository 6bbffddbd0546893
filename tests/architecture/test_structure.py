"""File lengths, meaningful names, and what a start of the program must not import."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "src" / "rostether"
MODULES = sorted(PACKAGE.rglob("*.py"))
LONG_FILE_LINES = 300
# Each file has one concept, and a review found that splitting it would not help a reader.
REVIEWED_LONG_FILES = {
    "bridge/session.py",
    "bridge/supervisor.py",
    "firmware/elf.py",
    "gateways/websocket/connection.py",
    "msgdef/registry.py",
    "rospy/bag/bag.py",
    "rosserial/device_link.py",
    "rosserial/frame_scan.py",
    "rosserial/host_link.py",
    "rosserial/negotiation.py",
    "serde/decoder_source.py",
    "transports/peers.py",
    "transports/tcp.py",
}
VAGUE_NAMES = {"util", "utils", "helper", "helpers", "manager", "common", "misc", "base"}
# `core` is the verb that every ROS user knows, and rospy's programs import modules by their names.
ALLOWED = {PACKAGE / "cli" / "bridge" / "core.py", *(PACKAGE / "rospy" / "modules").rglob("*.py")}
HEAVY = {
    "numpy",
    "rosbags",
    "rich",
    "serialx",
    "elftools",
    "zeroconf",
    "xml.dom",
    "http.client",
    "email",
    "multiprocessing",
    "importlib.metadata",
    "statistics",
    "ctypes",
    "rostether.gateways",
}


def test_only_reviewed_files_are_long() -> None:
    long = {
        str(module.relative_to(PACKAGE))
        for module in MODULES
        if len(module.read_text().splitlines()) > LONG_FILE_LINES
    }
    assert long == REVIEWED_LONG_FILES, (
        "split the long file, or get a review and add it to the list; remove files that are short now"
    )


def test_module_names_are_specific() -> None:
    parts = {(path, part) for path in MODULES for part in path.relative_to(PACKAGE).with_suffix("").parts}
    vague = {path for path, part in parts if part in VAGUE_NAMES or part == "core"}
    assert vague <= ALLOWED


@pytest.mark.usefixtures("cold_start")
@pytest.mark.parametrize(
    "module",
    ["rostether", "rostether.cli.main", "rostether.cli.bridge.serve, rostether.bridge.supervisor"],
)
def test_imports_load_no_heavy_module(module: str) -> None:
    code = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not HEAVY & set(loaded.stdout.split())


def test_no_transport_writes_lines() -> None:
    # Transport.writelines of Python 3.12.0 to 3.12.8, 3.13.0 and 3.13.1 grows without limit (CVE-2024-12254).
    assert [path for path in MODULES if ".writelines(" in path.read_text()] == []
