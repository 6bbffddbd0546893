"""JSON files in which a program keeps its state between runs."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
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


def store_state(path: Path, values: Mapping[str, Any]) -> None:
    """Replace the file in one step: a killed process leaves a complete one. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    fresh.write_text(json.dumps({"format": _FORMAT, **values}, indent=1) + "\n", encoding="utf-8")
    fresh.replace(path)
