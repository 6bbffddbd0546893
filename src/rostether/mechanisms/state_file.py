"""JSON files in which a program keeps its state between runs."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

_FORMAT = 1


def load_state(path: Path, max_bytes: int) -> dict[str, Any]:
    """Return the stored values; none if the file is missing, damaged, longer, or of another format."""
    try:
        with path.open("rb") as file:
            content = json.loads(file.read(max_bytes))
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) and content.get("format") == _FORMAT else {}


def store_state(path: Path, values: Mapping[str, Any], *, durable: bool = False) -> None:
    """Replace the file in one step: a killed process leaves a complete one. Raises OSError.

    `durable`: also after a power cut, the file is the old or the new one. This can take seconds on a memory
    card: not on the event loop.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with fresh.open("w", encoding="utf-8") as file:
            file.write(json.dumps({"format": _FORMAT, **values}, indent=1) + "\n")
            if durable:
                file.flush()
                os.fsync(file.fileno())
        fresh.replace(path)
    except OSError:
        # On a full disk, an incomplete file would take the last free space.
        with suppress(OSError):
            fresh.unlink()
        raise
    if durable and hasattr(os, "O_DIRECTORY"):
        folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
        try:
            # The new name, too, must be on the disk.
            os.fsync(folder)
        finally:
            os.close(folder)
