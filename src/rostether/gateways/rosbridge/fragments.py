"""Splits and joins messages: rosbridge's `fragment` operation, without I/O.

A message's text is split into pieces. Each piece is a separate message with the id of the whole message, its
number from 0, and the total. Fragments may come in any order, and fragments of several messages may be
mixed.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, Final

from rostether.errors import RemoteProtocolError

# The limit of fragments in one message: the largest message in fragments of a hundred characters.
MAX_FRAGMENTS: Final = 100_000

# The limit of incomplete messages of one client; above it, the oldest is discarded.
MAX_UNFINISHED: Final = 32

# The limit of waiting fragments of all messages: even an empty one needs about a hundred bytes.
MAX_UNFINISHED_PIECES: Final = 2 * MAX_FRAGMENTS


def split_fragments(text: str, size: int, message_id: str) -> Iterator[str]:
    """Yield a message's fragments as JSON: of `size` characters, or more if there would be too many."""
    size = max(size, -(-len(text) // MAX_FRAGMENTS))
    total = -(-len(text) // size)
    for number in range(total):
        piece = text[number * size : (number + 1) * size]
        fields = {"op": "fragment", "id": message_id, "data": piece, "num": number, "total": total}
        yield json.dumps(fields, separators=(",", ":"))


class _UnfinishedMessage:
    def __init__(self, total: int) -> None:
        self.total = total
        self.size = 0
        self.pieces: dict[int, str] = {}


class Defragmenter:
    """Joins a client's fragments; beyond `max_bytes` the oldest incomplete message is discarded."""

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._size = 0
        self._pieces = 0
        self._unfinished: dict[str | int, _UnfinishedMessage] = {}

    def add(self, fields: Mapping[str, Any]) -> str | None:
        """Add a fragment; return the whole text after the last one. Raises RemoteProtocolError."""
        message_id, data = fields.get("id"), fields.get("data")
        number, total = fields.get("num"), fields.get("total")
        if not isinstance(message_id, str | int) or not isinstance(data, str):
            raise RemoteProtocolError("fragment: give an id, and data (a string)")
        if type(number) is not int or type(total) is not int or not 0 <= number < total <= MAX_FRAGMENTS:
            raise RemoteProtocolError(
                f"fragment: num counts from 0 and stays below total, which is {MAX_FRAGMENTS} at most"
            )
        # A message becomes the newest with each of its fragments.
        known = self._unfinished.get(message_id)
        if known is not None and known.total != total:
            self._forget(message_id)
        whole = self._unfinished.pop(message_id, None) or _UnfinishedMessage(total)
        self._unfinished[message_id] = whole
        # A piece may be repeated.
        self._pieces += number not in whole.pieces
        grown = len(data) - len(whole.pieces.get(number, ""))
        whole.pieces[number] = data
        whole.size += grown
        self._size += grown
        while (
            self._size > self._max_bytes
            or self._pieces > MAX_UNFINISHED_PIECES
            or len(self._unfinished) > MAX_UNFINISHED
        ):
            oldest = next(iter(self._unfinished))
            self._forget(oldest)
            if oldest == message_id:
                raise RemoteProtocolError(f"fragment: a message may have at most {self._max_bytes} bytes")
        if len(whole.pieces) < total:
            return None
        self._forget(message_id)
        return "".join(whole.pieces[each] for each in range(total))

    def _forget(self, message_id: str | int) -> None:
        whole = self._unfinished.pop(message_id)
        self._size -= whole.size
        self._pieces -= len(whole.pieces)
