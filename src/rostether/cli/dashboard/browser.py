"""Opens pages in the user's browser."""

from __future__ import annotations

import asyncio
import sys
import webbrowser
from collections.abc import Mapping


async def open_browser(url: str) -> None:
    """Open an address in the user's browser, if there is one."""
    # A browser that does not start is not an error: the terminal shows the address.
    await asyncio.gather(asyncio.to_thread(webbrowser.open, url), return_exceptions=True)


def has_browser(environ: Mapping[str, str]) -> bool:
    """Return whether a window can open: a text browser in this terminal would hide the output."""
    if not sys.stdout.isatty():
        return False
    if sys.platform in ("darwin", "win32"):
        return "SSH_CONNECTION" not in environ
    return bool(environ.get("DISPLAY") or environ.get("WAYLAND_DISPLAY"))
