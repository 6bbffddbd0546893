"""The files and folders of a user's settings, known boards, certificates and recordings."""

from __future__ import annotations

from pathlib import Path

from rostether.mechanisms.user_folders import FolderKind, user_folder


def devices_toml_path() -> Path:
    """Return `~/.config/rostether/devices.toml` (XDG_CONFIG_HOME; on Windows below APPDATA)."""
    return user_folder(FolderKind.CONFIG) / "devices.toml"


def known_boards_path() -> Path:
    """Return `~/.local/state/rostether/boards.json` (XDG_STATE_HOME; on Windows below LOCALAPPDATA)."""
    return user_folder(FolderKind.STATE) / "boards.json"


def sensors_path() -> Path:
    """Return `~/.local/state/rostether/sensors.json` (XDG_STATE_HOME; on Windows below LOCALAPPDATA)."""
    return user_folder(FolderKind.STATE) / "sensors.json"


def certificates_folder() -> Path:
    """Return `~/.local/state/rostether/tls` (XDG_STATE_HOME; on Windows below LOCALAPPDATA)."""
    return user_folder(FolderKind.STATE) / "tls"


def recordings_folder() -> Path:
    """Return `~/.local/share/rostether/recordings` (XDG_DATA_HOME; on Windows below LOCALAPPDATA)."""
    return user_folder(FolderKind.DATA) / "recordings"
