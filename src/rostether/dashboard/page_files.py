"""The files of the dashboard's page, as they are installed with rostether."""

from __future__ import annotations

from pathlib import Path

from rostether.gateways.websocket.site import Site

PAGE = Path(__file__).parent / "page"


def load_page() -> Site:
    """Return the page; takes a while, since it reads and compresses all files. Raises ConfigError."""
    return Site.of_folder(PAGE)
