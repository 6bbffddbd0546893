"""The command lines that start rostether's verbs in other processes, and the tool that the user has typed."""

from __future__ import annotations

import os
import sys

# The scripts of `rostether env` set it to the name of the ROS tool that the user has typed.
CALLED_AS_VARIABLE = "ROSTETHER_CALLED_AS"


def own_command(*words: str) -> list[str]:
    """Return the command line of a rostether verb, run by this Python."""
    # Without -P, a file in the current folder could replace one of rostether's modules.
    return [sys.executable, "-P", "-m", "rostether", *words]


def called_as() -> str:
    """Return the name of the ROS tool that the user has typed, or an empty string."""
    return os.environ.get(CALLED_AS_VARIABLE, "")
