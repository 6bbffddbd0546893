"""JSON files in which a program keeps its state between runs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rostether.mechanisms.whole_file import write_whole

_FORMAT = 1


def load_state(path: Path, max_bytes: int) -> dict[str, Any]:
    """Return the stored values; none if the file is missing, damaged, too long, or of another format."""
    try:
        with path.open("rb") as file:
            content = json.loads(file.read(max_bytes))
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) and content.get("format") == _FORMAT else {}


def store_state(path: Path, values: Mapping[str, Any], *, is_durable: bool = False) -> None:
    """Replace the file in one step, see `write_whole`. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"format": _FORMAT, **values}, indent=1) + "\n"
    write_whole(path, text.encode(), is_durable=is_durable)
