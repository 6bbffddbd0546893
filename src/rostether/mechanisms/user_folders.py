"""The folders of a user for settings, state, data and caches, on each system."""

from __future__ import annotations

import os
import sys
from enum import Enum
from pathlib import Path


class FolderKind(Enum):
    """The purpose of a folder: XDG variable, paths below HOME on Linux and macOS, variable of Windows."""

    CONFIG = ("XDG_CONFIG_HOME", ".config", ".config", "APPDATA")
    STATE = ("XDG_STATE_HOME", ".local/state", ".local/state", "LOCALAPPDATA")
    DATA = ("XDG_DATA_HOME", ".local/share", ".local/share", "LOCALAPPDATA")
    CACHE = ("XDG_CACHE_HOME", ".cache", "Library/Caches", "LOCALAPPDATA")


def user_folder(kind: FolderKind) -> Path:
    """Return rostether's folder of a kind; it may not exist yet."""
    variable, below_home, on_mac, on_windows = kind.value
    given = os.environ.get(variable, "")
    # The XDG specification requires that relative paths are ignored.
    if given and Path(given).is_absolute():
        return Path(given) / "rostether"
    if sys.platform == "win32" and os.environ.get(on_windows):
        return Path(os.environ[on_windows]) / "rostether"
    home = Path(os.environ.get("HOME") or "~").expanduser()
    return home / (on_mac if sys.platform == "darwin" else below_home) / "rostether"
