"""One message of a client: its fields, each read with its required type."""

from __future__ import annotations

import asyncio
import gc
import json
import math
from collections.abc import Callable
from typing import Any, Final

from rostether.errors import RemoteProtocolError
from rostether.gateways.client_json import count_values, parse_in_steps, parse_json, show
from rostether.mechanisms.text import counted
from rostether.serde.codec import Codec

# The limit of names and ids: thousands are stored, and all nodes see them. Real ones have fewer than 150
# characters.
MAX_WORD_CHARACTERS: Final = 512

# More values are parsed in a thread, because they may take longer than 10 ms.
_MANY_VALUES: Final = 1 << 14

# For larger frames, garbage collection may take longer than parsing.
_LARGE_BYTES: Final = 64 << 10


class Request:
    """A JSON object with an `op`, received in a frame of `size_bytes` with about `value_count` values.

    `value_count` is 0 for a small message.
    """

    def __init__(self, fields: dict[str, Any], size_bytes: int = 0, value_count: int = 0) -> None:
        self.fields = fields
        self.size_bytes = size_bytes
        self.value_count = value_count
        self.op = self.word("op")

    @property
    def id(self) -> object:
        """The client's own id of the message; None without a valid one.

        Raises RemoteProtocolError if it is too long.
        """
        found = self.fields.get("id")
        if isinstance(found, str):
            self._check_length("id", found)
        # Python's json reads NaN, which would make the answer invalid JSON.
        is_valid = isinstance(found, str | int) or (isinstance(found, float) and math.isfinite(found))
        return found if is_valid else None

    def text(self, name: str) -> str:
        """Return a required text field. Raises RemoteProtocolError."""
        value = self.fields.get(name)
        if not isinstance(value, str):
            raise self._field_error(name, "a string")
        return value

    def word(self, name: str) -> str:
        """Return a name or id, a text of limited length. Raises RemoteProtocolError."""
        value = self.text(name)
        self._check_length(name, value)
        return value

    def optional_word(self, name: str) -> str:
        """Return a name or id, empty if it is missing or null. Raises RemoteProtocolError."""
        return "" if self.fields.get(name) is None else self.word(name)

    def number(self, name: str, default: float) -> float:
        """Return a number that is not negative; browsers send some as strings. Raises RemoteProtocolError."""
        value = self.fields.get(name)
        if value is None:
            return default
        try:
            number = float(value) if isinstance(value, int | float | str) else math.nan
        except (ValueError, OverflowError):
            number = math.nan
        if not 0 <= number < math.inf:
            raise self._field_error(name, "a number, zero or more")
        return number

    def count(self, name: str, default: int) -> int:
        """Return a whole number that is not negative. Raises RemoteProtocolError."""
        return int(self.number(name, default))

    def flag(self, name: str) -> bool:
        """Return a boolean, False if it is missing. Raises RemoteProtocolError."""
        value = self.fields.get(name, False)
        if value is not None and not isinstance(value, bool | int):
            raise self._field_error(name, "true or false")
        return bool(value)

    def _check_length(self, name: str, value: str) -> None:
        if len(value) > MAX_WORD_CHARACTERS:
            raise self._field_error(name, f"at most {MAX_WORD_CHARACTERS} characters")

    def _field_error(self, name: str, wanted: str) -> RemoteProtocolError:
        op = self.fields.get("op")
        subject = f"{show(op)[1:-1]}: " if isinstance(op, str) and name != "op" else ""
        got = show(self.fields[name]) if name in self.fields else "nothing"
        return RemoteProtocolError(f"{subject}field '{name}' must be {wanted}, got {got}")


def fields_by_name(request: Codec, args: Any) -> dict[str, Any]:
    """Return the fields of a service's request by name.

    A client may also send a list of their values, or only the first value. Raises RemoteProtocolError for too
    many values.
    """
    if args is None or isinstance(args, dict):
        return args or {}
    names = [member.name for member in request.tree.members]
    values = args if isinstance(args, list) else [args]
    if len(values) > len(names):
        fields = counted(len(names), "field")
        raise RemoteProtocolError(
            f"call_service: {request.type_name} has {fields}, but args has {counted(len(values), 'value')}"
        )
    return dict(zip(names, values, strict=False))


async def read_request(data: str | bytes) -> Request:
    """Return the message in a frame. Raises RemoteProtocolError."""
    try:
        text = data if isinstance(data, str) else data.decode(json.detect_encoding(data), "surrogatepass")
        value_count = count_values(text)
        is_slow = value_count > _MANY_VALUES
        fields = await asyncio.to_thread(_parsed, text, parse_in_steps) if is_slow else _parsed(text)
    except RecursionError:
        raise RemoteProtocolError("this JSON is nested too deeply") from None
    except ValueError as error:
        raise RemoteProtocolError(f"this is not JSON: {error}; got {show(data)}") from None
    if not isinstance(fields, dict):
        raise RemoteProtocolError(f"a message must be a JSON object with an op, got {show(fields)}")
    return Request(fields, len(data), value_count)


def _parsed(text: str, parse: Callable[[str], Any] = parse_json) -> Any:
    """Return parsed JSON, without garbage collection: parsing creates no garbage."""
    if len(text) < _LARGE_BYTES or not gc.isenabled():
        return parse(text)
    gc.disable()
    try:
        return parse(text)
    finally:
        gc.enable()
