"""Captures of all bytes of links, as JSON Lines that users can attach to a report.

    {"capture": "arm", "started": "2026-01-31T12:00:00Z", ...}          the description, with any keys
    {"t": 0.0, "event": "opened", "peer": "/dev/ttyACM0"}                a link begins
    {"t": 0.001, "from": "host", "hex": "fffe0000ff0000ff"}              bytes, cut anywhere
    {"t": 0.021, "from": "device", "hex": "fffe0800f70a00..."}
    {"t": 9.5, "event": "closed"}                                        a link ends

`t` is in seconds since the start. Links after the first have their number as `link`. Events may be missing:
a capture with only bytes is of one link that was always open. Unknown keys and events are skipped.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, TypeVar

import msgspec
from msgspec import Meta, Struct

from rostether.errors import ConfigError
from rostether.mechanisms.json_fault import explain_fault
from rostether.mechanisms.text import read_failure

# A chunk has at most 128 KiB, thus 256 KiB of hex; a much longer line is not from a capture.
MAX_LINE_BYTES = 4 << 20

# Three years: a larger time is a mistake, and a replay would wait for it.
MAX_TIME_S = 1e8

FIRST_LINK = 1

_T = TypeVar("_T")


class Chunk(Struct, frozen=True):
    """Bytes of one side at one time."""

    time_s: float
    link: int
    from_device: bool
    data: bytes


class LinkOpened(Struct, frozen=True):
    """A link begins; `peer` is the other side."""

    time_s: float
    link: int
    peer: str


class LinkClosed(Struct, frozen=True):
    """A link ends."""

    time_s: float
    link: int


Entry: TypeAlias = Chunk | LinkOpened | LinkClosed


class Capture:
    """A capture's first line, and its entries one by one, so that a file of any size needs little memory.

    Raises ConfigError with the number of the first line that is not of a capture.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.description = self._read_description()

    @property
    def version(self) -> int | None:
        """The protocol version in the first line, 1 or 2; None if it has no such version."""
        given = self.description.get("protocol")
        return given if given in (1, 2) else None

    def entries(self) -> Iterator[Entry]:
        """Yield the entries in the order of the file; their times never decrease."""
        last_s = 0.0
        for number, line, is_whole in self._lines():
            if number == 1 or not line.strip():
                continue
            try:
                entry = _entry(_decoded(line, _Line), last_s)
            except ValueError as error:
                # A recorder that was killed left its last line unfinished.
                if not is_whole:
                    return
                raise ConfigError(
                    f"{self.path}, line {number}: {error}; correct or remove the line"
                ) from None
            if entry is not None:
                last_s = entry.time_s
                yield entry

    def _read_description(self) -> Mapping[str, Any]:
        for _, line, _ in self._lines():
            try:
                found = _decoded(line, dict[str, Any])
            except ValueError as error:
                raise ConfigError(
                    f"{self.path}, line 1: {error}; is it a capture of `rostether link record`?"
                ) from None
            if "hex" in found or "capture" not in found:
                raise ConfigError(
                    f"{self.path}, line 1: no header of a capture, such as "
                    '{"capture": "arm"}; is it a capture of `rostether link record`?'
                )
            return found
        raise ConfigError(f"{self.path} is empty; record it again with `rostether link record`")

    def _lines(self) -> Iterator[tuple[int, bytes, bool]]:
        try:
            with self.path.open("rb") as file:
                number = 0
                while line := file.readline(MAX_LINE_BYTES):
                    number += 1
                    is_whole = line.endswith(b"\n")
                    if not is_whole and len(line) == MAX_LINE_BYTES:
                        raise ConfigError(
                            f"{self.path}, line {number}: longer than {MAX_LINE_BYTES >> 20} MiB; "
                            "is it a capture of `rostether link record`?"
                        )
                    yield number, line, is_whole
        except OSError as error:
            raise ConfigError(read_failure(self.path, error)) from error


class _Line(Struct, rename={"time_s": "t", "sender": "from"}):
    time_s: Annotated[float, Meta(ge=0, le=MAX_TIME_S)]
    link: Annotated[int, Meta(ge=FIRST_LINK)] = FIRST_LINK
    event: str | None = None
    peer: str = ""
    sender: Literal["device", "host"] | None = None
    hex: str | None = None


def _decoded(line: bytes, kind: type[_T]) -> _T:
    try:
        return msgspec.json.decode(line, type=kind)
    except RecursionError:
        raise ValueError("JSON is nested too deeply") from None
    except ValueError as error:
        raise ValueError(explain_fault(error)) from None


def _entry(line: _Line, last_s: float) -> Entry | None:
    time_s = max(line.time_s, last_s)
    if line.event == "opened":
        return LinkOpened(time_s, line.link, line.peer)
    if line.event == "closed":
        return LinkClosed(time_s, line.link)
    if line.event is not None:
        return None
    if line.sender is None or line.hex is None:
        raise ValueError("neither an event, nor bytes with `from` and `hex`")
    try:
        data = bytes.fromhex(line.hex)
    except ValueError:
        raise ValueError("`hex` is not hexadecimal") from None
    return Chunk(time_s, line.link, line.sender == "device", data)
