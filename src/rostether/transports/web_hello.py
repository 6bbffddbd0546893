"""The description of a board that a web page connects: the text messages of `WS /serial`, sans I/O."""

from __future__ import annotations

from typing import Annotated, TypeVar

import msgspec
from msgspec import Meta, Struct

from rostether.errors import RemoteProtocolError
from rostether.mechanisms.json_fault import explain_fault
from rostether.transports.address_parser import MAX_BAUD

# A hello has about 100 characters.
MAX_TEXT_CHARACTERS = 1000

# More than a line of 20 Mbaud transfers in a century.
_MAX_BYTES = 1 << 53

_T = TypeVar("_T")


class WebHello(Struct, frozen=True, tag_field="op", tag="connect"):
    """A page's first message.

    `name` is the board's name for users. `key` is a random text that stays the same while the page reconnects
    this board. `baud` is the baud rate of its serial port.
    """

    name: Annotated[str, Meta(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,39}\Z")]
    key: Annotated[str, Meta(pattern=r"^[A-Za-z0-9-]{8,64}\Z")]
    baud: Annotated[int, Meta(ge=1, le=MAX_BAUD)]


class _WriteProgress(Struct, tag_field="op", tag="written"):
    bytes: Annotated[int, Meta(ge=0, le=_MAX_BYTES)]


def read_hello(text: str) -> WebHello:
    """Return the first message of a page. Raises RemoteProtocolError with the reason."""
    return _read(text, WebHello)


def read_progress(text: str) -> int:
    """Return how many bytes a page has written to its port so far. Raises RemoteProtocolError."""
    return _read(text, _WriteProgress).bytes


def _read(text: str, kind: type[_T]) -> _T:
    if len(text) > MAX_TEXT_CHARACTERS:
        raise RemoteProtocolError(f"a text message has at most {MAX_TEXT_CHARACTERS} characters")
    try:
        return msgspec.json.decode(text, type=kind)
    except (ValueError, RecursionError) as error:
        raise RemoteProtocolError(f"a text message is invalid: {explain_fault(error)}") from None
