"""The files of the dashboard's page, as they are installed with rostether."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rostether.gateways.websocket.site import Downloads, Site, Tiles

PAGE = Path(__file__).parent / "page"


def load_page(
    more: Mapping[str, bytes] | None = None, downloads: Downloads | None = None, tiles: Tiles | None = None
) -> Site:
    """Return the page, and more files; reads and compresses all of them. Raises ConfigError."""
    return Site.of_folder(PAGE, more, downloads, tiles)
