"""One message of a client: its fields, each asked for with the type that it must have."""

from __future__ import annotations

import gc
import json
import math
from typing import Any, Final

from rostether.errors import RemoteProtocolError
from rostether.gateways.rosbridge.status import show

MAX_WORD_CHARACTERS: Final = 512
"""Names and ids: they are kept by the thousand, and shown to the whole graph; those in use are below 150."""


class Request:
    """A JSON object with an `op`, which came in a frame of `size_bytes`."""

    def __init__(self, fields: dict[str, Any], size_bytes: int = 0) -> None:
        self.fields = fields
        self.size_bytes = size_bytes
        self.op = self.word("op")

    @property
    def id(self) -> object:
        """The client's own id of the message; None where it gave none or nothing that can be one.

        Raises RemoteProtocolError for one that is too long to be kept.
        """
        found = self.fields.get("id")
        if isinstance(found, str):
            self._check_length("id", found)
        # NaN comes in with Python's reader of JSON, and would go out as what is none.
        is_one = isinstance(found, str | int) or (isinstance(found, float) and math.isfinite(found))
        return found if is_one else None

    def text(self, name: str) -> str:
        """Return a field that must be there and be a text. Raises RemoteProtocolError."""
        value = self.fields.get(name)
        if not isinstance(value, str):
            raise self._wrong(name, "a text")
        return value

    def word(self, name: str) -> str:
        """Return a text that names something. Raises RemoteProtocolError, also if it is too long."""
        value = self.text(name)
        self._check_length(name, value)
        return value

    def optional_word(self, name: str) -> str:
        """Return a word, empty where it is missing or null. Raises RemoteProtocolError."""
        return "" if self.fields.get(name) is None else self.word(name)

    def number(self, name: str, default: float) -> float:
        """Return a number that is not negative; browsers send some as texts. Raises RemoteProtocolError."""
        value = self.fields.get(name)
        if value is None:
            return default
        try:
            number = float(value) if isinstance(value, int | float | str) else math.nan
        except (ValueError, OverflowError):
            number = math.nan
        if not 0 <= number < math.inf:
            raise self._wrong(name, "a number, zero or more")
        return number

    def count(self, name: str, default: int) -> int:
        """Return a whole number that is not negative. Raises RemoteProtocolError."""
        return int(self.number(name, default))

    def flag(self, name: str) -> bool:
        """Return a boolean, False where it is missing. Raises RemoteProtocolError."""
        value = self.fields.get(name, False)
        if value is not None and not isinstance(value, bool | int):
            raise self._wrong(name, "true or false")
        return bool(value)

    def _check_length(self, name: str, value: str) -> None:
        if len(value) > MAX_WORD_CHARACTERS:
            raise self._wrong(name, f"{MAX_WORD_CHARACTERS} characters at most")

    def _wrong(self, name: str, wanted: str) -> RemoteProtocolError:
        op = self.fields.get("op")
        subject = f"{show(op)[1:-1]}: " if isinstance(op, str) and name != "op" else ""
        got = show(self.fields[name]) if name in self.fields else "nothing"
        return RemoteProtocolError(f"{subject}field '{name}' wants {wanted}, got {got}")


_LARGE_BYTES: Final = 64 << 10
"""From here on looking for garbage among what a frame holds may take longer than reading it."""


def read_request(data: str | bytes) -> Request:
    """Return the message in a frame. Raises RemoteProtocolError."""
    try:
        fields = _parsed(data)
    except RecursionError:
        raise RemoteProtocolError("this JSON is nested too deeply") from None
    except ValueError as error:
        raise RemoteProtocolError(f"this is no JSON: {error}; got {show(data)}") from None
    if not isinstance(fields, dict):
        raise RemoteProtocolError(f"a message is a JSON object with an op, got {show(fields)}")
    return Request(fields, len(data))


def _parsed(data: str | bytes) -> Any:
    """Return what JSON holds, of which nothing is garbage yet: no time is spent to look for it."""
    if len(data) < _LARGE_BYTES or not gc.isenabled():
        return json.loads(data)
    gc.disable()
    try:
        return json.loads(data)
    finally:
        gc.enable()
