"""A part of the dashboard's page that opens first, such as a plot of one value, and the browser for it."""

from __future__ import annotations

import asyncio
import base64
import json
import sys
import webbrowser
from collections.abc import Mapping, Sequence
from pathlib import Path
from urllib.parse import quote

from msgspec import Struct, field

from rostether.cli.shell.input import read_bytes
from rostether.errors import ConfigError

# The panels of the page, as in its addresses.
PANELS = (
    "boards",
    "fleet",
    "sensors",
    "controls",
    "drive",
    "plots",
    "images",
    "scene",
    "map",
    "graph",
    "topics",
    "services",
    "parameters",
    "console",
    "diagnostics",
    "frames",
    "recording",
    "simulation",
    "connect",
    "phone",
)

# RViz writes about 10 kB.
_MAX_RVIZ_BYTES = 1 << 20


class View(Struct, frozen=True):
    """A panel with its settings; `files` are served with the page."""

    panel: str
    settings: Mapping[str, object] = field(default_factory=dict)
    files: Mapping[str, bytes] = field(default_factory=dict)

    def fragment(self, token: str) -> str:
        """Return the part of the address after `#`."""
        words = []
        if self.settings:
            packed = json.dumps(self.settings, separators=(",", ":")).encode()
            words.append(f"s={base64.urlsafe_b64encode(packed).decode().rstrip('=')}")
        if token:
            words.append(f"token={quote(token, safe='')}")
        return f"/{self.panel}{'?' if words else ''}{'&'.join(words)}"


def read_view(panel: str, shown: Sequence[str]) -> View:
    """Return the view of a panel that shows these values, topics or this .rviz file. Raises ConfigError."""
    if not shown:
        return View(panel)
    match panel:
        case "plots":
            return View(panel, {"names": list(shown)})
        case "images":
            return View(panel, {"topic": shown[0]})
        case "topics":
            return View(panel, {"search": shown[0]})
        case "scene":
            return _read_rviz(Path(shown[0]))
        case _:
            return View(panel)


def _read_rviz(path: Path) -> View:
    content = read_bytes(path)
    if len(content) > _MAX_RVIZ_BYTES:
        raise ConfigError(f"{path} is larger than {_MAX_RVIZ_BYTES >> 20} MiB; give an .rviz file")
    return View("scene", {"rviz": "view.rviz"}, {"view.rviz": content})


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
