"""The files of the dashboard's page, as they are installed with rostether."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rostether.errors import ConfigError
from rostether.gateways.websocket.site import INDEX, FindFile, Site, Tiles

PAGE = Path(__file__).parent / "page"


def load_page(
    more: Mapping[str, bytes], find_download: FindFile | None = None, tiles: Tiles | None = None
) -> Site:
    """Return the page, and more files; reads and compresses all of them. Raises ConfigError."""
    try:
        files = {
            file.relative_to(PAGE).as_posix(): file.read_bytes() for file in PAGE.rglob("*") if file.is_file()
        }
    except OSError as error:
        raise ConfigError(
            f"the page in {PAGE} cannot be read: {error.strerror}; install rostether again"
        ) from None
    if INDEX not in files:
        raise ConfigError(f"the page in {PAGE} is incomplete: {INDEX} is missing; install rostether again")
    return Site(files | dict(more), find_download, tiles)
