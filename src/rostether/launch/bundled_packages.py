"""Bundled packages: their launch files work under the usual names if no such package is installed."""

from __future__ import annotations

from pathlib import Path

_FOLDER = Path(__file__).with_name("share")


def bundled_packages() -> dict[str, Path]:
    """Map the names of bundled packages to their folders; user packages with the same name have priority."""
    return {folder.name: folder for folder in sorted(_FOLDER.iterdir()) if folder.is_dir()}
