"""Runs systemd's programs for the service of `rostether install`."""

from __future__ import annotations

import getpass
import subprocess
from collections.abc import Sequence
from pathlib import Path

from rostether.cli.shell.output import write_line
from rostether.errors import ConfigError
from rostether.platform.boot.service_files import STATE, Installation

UNIT = "rostether.service"
# Where logind keeps the users whose services start at boot.
_LINGERING = Path("/var/lib/systemd/linger")
# systemd kills a service that does not stop within 10 s; a slow machine needs more time.
_LIMIT_S = 60.0


def systemctl(installation: Installation, *words: str) -> str:
    """Run `systemctl` for the system's or the user's services; return its output. Raises ConfigError."""
    return _output_of(["systemctl", *([] if installation.is_system else ["--user"]), *words])


def _output_of(command: Sequence[str]) -> str:
    """Run a program of systemd and return its output. Raises ConfigError if it fails."""
    try:
        done = subprocess.run(  # noqa: S603 - systemd's programs
            command, capture_output=True, text=True, timeout=_LIMIT_S, check=False
        )
    except FileNotFoundError:
        raise ConfigError(f"this machine has no {command[0]}; it needs systemd") from None
    except subprocess.TimeoutExpired:
        raise ConfigError(
            f"{' '.join(command)} did not end within {_LIMIT_S:.0f} s; try again, or restart this machine"
        ) from None
    if done.returncode:
        raise ConfigError(f"{' '.join(command)} failed: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout


def linger() -> None:
    """Make this user's services start at boot. Raises ConfigError.

    Without it, they run from the first log-in to the last log-out.
    """
    command = ["loginctl", "enable-linger", getpass.getuser()]
    try:
        _output_of(command)
    except ConfigError:
        raise ConfigError(
            "rostether runs now, and each time you log in; to start it at boot, type: "
            f"sudo {' '.join(command)}"
        ) from None


def is_lingering() -> bool:
    """Return whether this user's services start at boot."""
    return _LINGERING.joinpath(getpass.getuser()).exists()


def clean(installation: Installation) -> None:
    """Remove the service's cache, and its state unless parts have written files there, such as recordings.

    Raises ConfigError if systemd refuses.
    """
    is_written = any(each.is_file() for each in STATE.resolve().rglob("*"))
    folders = ["--what=cache"] if is_written else ["--what=cache", "--what=state"]
    systemctl(installation, "clean", *folders, UNIT)
    if is_written:
        write_line(
            f"kept {STATE} with the files that the robot wrote; to remove them: sudo rm -r {STATE.resolve()}"
        )
