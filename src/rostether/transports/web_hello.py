"""The description of a board that a web page connects: the text messages of `WS /serial`, sans I/O."""

from __future__ import annotations

import json
import re
from typing import Any

from msgspec import Struct

from rostether.errors import RemoteProtocolError
from rostether.transports.address_parser import MAX_BAUD

# A hello has about 100 characters.
MAX_TEXT_CHARACTERS = 1000
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_ID = re.compile(r"[A-Za-z0-9-]{8,64}")

# More than a line of 20 Mbaud transfers in a century.
_MAX_BYTES = 1 << 53


class WebHello(Struct, frozen=True):
    """A page's first message.

    `name` is the board's name for users. `key` is a random text that stays the same while the page reconnects
    this board. `baud` is the baud rate of its serial port.
    """

    name: str
    key: str
    baud: int


def read_hello(text: str) -> WebHello:
    """Return the first message of a page. Raises RemoteProtocolError with the reason."""
    message = _read(text, "connect")
    name, key, baud = message.get("name"), message.get("key"), message.get("baud")
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise RemoteProtocolError(
            "the name of a board has 1 to 40 letters, digits or _, and begins with a letter"
        )
    if not isinstance(key, str) or not _ID.fullmatch(key):
        raise RemoteProtocolError("the key of a board has 8 to 64 letters, digits or -")
    if isinstance(baud, bool) or not isinstance(baud, int) or not 1 <= baud <= MAX_BAUD:
        raise RemoteProtocolError(f"the baud rate must be 1 to {MAX_BAUD}")
    return WebHello(name, key, baud)


def read_progress(text: str) -> int:
    """Return how many bytes a page has written to its port so far. Raises RemoteProtocolError."""
    written = _read(text, "written").get("bytes")
    if isinstance(written, bool) or not isinstance(written, int) or not 0 <= written <= _MAX_BYTES:
        raise RemoteProtocolError("the number of written bytes is missing")
    return written


def _read(text: str, op: str) -> dict[str, Any]:
    if len(text) > MAX_TEXT_CHARACTERS:
        raise RemoteProtocolError(f"a text message has at most {MAX_TEXT_CHARACTERS} characters")
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        message = None
    if not isinstance(message, dict) or message.get("op") != op:
        raise RemoteProtocolError(f'a text message with "op": "{op}" is expected')
    return message
