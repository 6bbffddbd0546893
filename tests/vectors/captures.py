"""Loads the recorded sessions that lie beside this file."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

_HERE = Path(__file__).parent


@dataclass(frozen=True, slots=True)
class Chunk:
    """Bytes of one side at one time; `clean` is what the device had sent where the line changed it."""

    time_s: float
    from_device: bool
    data: bytes
    clean: bytes


@dataclass(frozen=True, slots=True)
class Announced:
    """One endpoint as the capture's first line describes it."""

    kind: str
    name: str
    type: str
    md5sum: str
    buffer_size: int


@dataclass(frozen=True, slots=True)
class Capture:
    """One recorded session."""

    name: str
    version: int
    seconds: float
    topics: dict[int, Announced]
    chunks: tuple[Chunk, ...] = field(repr=False)

    def of_device(self) -> tuple[Chunk, ...]:
        """Return what came from the device."""
        return tuple(chunk for chunk in self.chunks if chunk.from_device)

    def of_host(self) -> tuple[Chunk, ...]:
        """Return what came from the host."""
        return tuple(chunk for chunk in self.chunks if not chunk.from_device)


def names() -> list[str]:
    """Return the names of all captures."""
    return sorted(path.stem for path in _HERE.glob("*.jsonl"))


@cache
def load(name: str) -> Capture:
    """Return one capture."""
    first, *lines = [json.loads(line) for line in (_HERE / f"{name}.jsonl").read_text().splitlines()]
    topics = {int(topic_id): Announced(**topic) for topic_id, topic in first["topics"].items()}
    chunks = tuple(
        Chunk(
            line["t"],
            line["from"] == "device",
            bytes.fromhex(line["hex"]),
            bytes.fromhex(line.get("clean", line["hex"])),
        )
        for line in lines
    )
    return Capture(first["capture"], first.get("protocol", 2), first["seconds"], topics, chunks)


def frame_counts() -> dict[str, tuple[int, int, int]]:
    """Return by capture: frames from the device, from the host, damaged, as README.md has them."""
    counts: dict[str, tuple[int, int, int]] = {}
    for line in (_HERE / "README.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 5 and cells[2].isdigit():
            counts[cells[0]] = int(cells[2]), int(cells[3]), int(cells[4])
    return counts
