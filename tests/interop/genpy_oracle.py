"""Asks Debian's genpy and rostopic about a batch of messages, in one process."""

from __future__ import annotations

import base64
import json
import subprocess
from pathlib import Path
from typing import Any

DEBIAN_PYTHON = "/usr/bin/python3"
REFERENCE = Path(__file__).parent / "peers" / "genpy_reference.py"
TIMEOUT_S = 100


def ask_genpy(requests: list[dict[str, Any]]) -> list[Any]:
    """Return one answer for each request; None for a type that Debian does not have."""
    completed = subprocess.run(
        [DEBIAN_PYTHON, str(REFERENCE)],
        input=json.dumps(requests).encode(),
        capture_output=True,
        timeout=TIMEOUT_S,
        env={"PATH": "/usr/bin", "LANG": "C.UTF-8"},
    )
    assert completed.returncode == 0, completed.stderr.decode()
    answers: list[Any] = json.loads(completed.stdout)
    assert len(answers) == len(requests)
    return answers


def as_text(payload: bytes) -> str:
    """Return bytes as text, for a request."""
    return base64.b64encode(payload).decode()


def as_bytes(text: str) -> bytes:
    """Return the bytes of an answer."""
    return base64.b64decode(text)
