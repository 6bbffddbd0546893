"""The command that installs one of rostether's extras in the current environment."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rostether.errors import ConfigError


def install_command(extra: str) -> str:
    """Return the command that adds an extra to the current environment.

    A bare `pip` belongs to another environment if pipx installed rostether, or if no environment is active.
    """
    wanted = f"'rostether[{extra}]'"
    if Path(sys.prefix, "pipx_metadata.json").exists():
        return f"pipx runpip {shlex.quote(Path(sys.prefix).name)} install {wanted}"
    if _is_made_by_uv():
        return f"uv pip install --python {shlex.quote(sys.executable)} {wanted}"
    if sys.prefix != sys.base_prefix and os.environ.get("VIRTUAL_ENV") != sys.prefix:
        return f"{shlex.quote(sys.executable)} -m pip install {wanted}"
    return f"pip install {wanted}"


@contextmanager
def imported_from(extra: str, problem: str) -> Iterator[None]:
    """Raise ConfigError with the problem and the command for the extra if an import in the block fails."""
    try:
        yield
    except ImportError:
        raise ConfigError(f"{problem}; run: {install_command(extra)}") from None


def _is_made_by_uv() -> bool:
    # uv's environments have no pip.
    try:
        lines = Path(sys.prefix, "pyvenv.cfg").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return False
    return any(line.startswith("uv =") for line in lines)
