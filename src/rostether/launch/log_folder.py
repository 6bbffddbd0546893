"""The log folder: ROS_LOG_DIR, else `log` in ROS_HOME (~/.ros), with a subfolder for each run."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path

from rostether.errors import ConfigError

_LATEST = "latest"


def ros_home(environ: Mapping[str, str]) -> Path:
    """Return the default working directory of nodes."""
    return Path(environ["ROS_HOME"]) if environ.get("ROS_HOME") else Path.home() / ".ros"


def log_folder(environ: Mapping[str, str], run_id: str) -> Path:
    """Create and return the log folder of a run; the link `latest` next to it points to it.

    Raises ConfigError.
    """
    parent = Path(environ["ROS_LOG_DIR"]) if environ.get("ROS_LOG_DIR") else ros_home(environ) / "log"
    # The id comes from a master: it must not point outside the folder.
    folder = parent.absolute() / run_id.replace("/", "-").strip(".")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(
            f"cannot create {folder}: {error.strerror}; set ROS_LOG_DIR to another folder"
        ) from None
    latest = parent / _LATEST
    with contextlib.suppress(OSError):
        if latest.is_symlink() or not latest.exists():
            latest.unlink(missing_ok=True)
            latest.symlink_to(folder)
    return folder
