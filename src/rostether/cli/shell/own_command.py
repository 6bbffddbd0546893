"""The command lines of rostether's verbs for other processes, and the tool that the user has typed."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence

from rostether.errors import ConfigError

# The scripts of `rostether env` set it to the name of the ROS tool that the user has typed.
CALLED_AS_VARIABLE = "ROSTETHER_CALLED_AS"


def own_command(*words: str) -> list[str]:
    """Return the command line of a rostether verb, run by this Python."""
    # Without -P, a file in the current folder could replace one of rostether's modules.
    return [sys.executable, "-P", "-m", "rostether", *words]


def called_as() -> str:
    """Return the name of the ROS tool that the user has typed, or an empty string."""
    return os.environ.get(CALLED_AS_VARIABLE, "")


def replace_process(words: Sequence[str], environ: Mapping[str, str]) -> None:
    """Replace this process: signals and the exit code are then the node's own. Raises ConfigError."""
    sys.stdout.flush()
    sys.stderr.flush()
    try:
        os.execvpe(words[0], list(words), environ)  # noqa: S606
    except OSError as error:
        raise ConfigError(
            f"{words[0]} cannot be run: {error.strerror}; check the path and the first line of the program"
        ) from error
