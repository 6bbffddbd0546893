"""Sketches written for a test, and a cache of compiled objects that all tests share."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from rostether.firmware.boards import Board
from rostether.firmware.build import find_board

EMPTY = "void setup() {}\nvoid loop() {}\n"


def write_sketch(folder: Path, name: str, text: str, others: Mapping[str, str] | None = None) -> Path:
    """Write folder/name/name.ino and other files of the sketch; return the sketch's folder."""
    sketch = folder / name
    for file, content in {f"{name}.ino": text, **(others or {})}.items():
        path = sketch / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
    return sketch


def users_cache() -> str:
    """Return this user's cache folder, for tests whose home is a folder of the test.

    Its entries are named after the hash of their content. Without it, each test would compile the simulator
    and the Arduino core.
    """
    return os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")


def uno() -> Board:
    return find_board("uno")
