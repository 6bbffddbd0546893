"""The command line of this program, to start a verb of it as another process."""

from __future__ import annotations

import sys


def our_command(*words: str) -> list[str]:
    """Return the command line of a rostether verb, run by this Python."""
    # Without -P, a file in the current folder could replace one of rostether's modules.
    return [sys.executable, "-P", "-m", "rostether", *words]
