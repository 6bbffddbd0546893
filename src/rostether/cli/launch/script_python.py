"""Chooses the Python for a user's node: the one in its first line, which has the user's modules.

rostether's own Python runs it if that one is missing (`#!/usr/bin/env python`), or too old for our rospy and
without a real one. ROSTETHER_PYTHON overrides the choice for all nodes.
"""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from rostether.packages.executables import shebang

PYTHON_VARIABLE = "ROSTETHER_PYTHON"

# A Python starts within a second, even on a busy small board.
_PROBE_LIMIT_S = 10.0
_PROBE = (
    "import sys, importlib.util as u; print(sys.version_info >= (3, 11) or u.find_spec('rospy') is not None)"
)


def python_for(script: Path, environ: Mapping[str, str]) -> list[str]:
    """Return the words before the script's path on its command line: a Python, and flags of its first line.

    Naming it lets scripts run that are not executable, or have Windows line ends.
    """
    if chosen := environ.get(PYTHON_VARIABLE):
        return [chosen]
    words = shebang(script).split()
    if words and Path(words[0]).name == "env":
        words = [each for each in words[1:] if each != "-S" and "=" not in each]
    named = shutil.which(words[0], path=environ.get("PATH")) if words else None
    if named is None or not _is_usable(named, environ.get("PYTHONPATH", "")):
        return [sys.executable]
    return [named, *words[1:]]


@functools.cache
def _is_usable(python: str, python_path: str) -> bool:
    """Return whether a Python has a real rospy, or can use the built-in one."""
    if python == sys.executable:
        return True
    try:
        answer = subprocess.run(  # noqa: S603 - the program that the user's script names
            [python, "-c", _PROBE],
            env={**os.environ, "PYTHONPATH": python_path},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_PROBE_LIMIT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return answer.stdout.strip() == b"True"
