"""The targets by name, their corpora, and running one input."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import cast

NAMES = (
    "frame_decoder",
    "packets",
    "host_link",
    "device_link",
    "tcpros",
    "xmlrpc",
    "http",
    "definitions",
    "cdr",
    "yaml_form",
    "devices_toml",
    "address",
    "psk_hello",
    "recordings",
    "rosbridge",
    "foxglove",
)
CORPORA = Path(__file__).parent / "corpora"
# No input of a few KB may hold a bridge up for as long as a board waits for its parameter.
LIMIT_S = 1.0


class SlowInputError(Exception):
    """An input took longer than anything of its size may."""


@dataclass(frozen=True, slots=True)
class Target:
    """One harness: `run` raises when a promise is broken, `seeds` are inputs that mean something."""

    name: str
    run: Callable[[bytes], None]
    seeds: Callable[[], list[bytes]]

    def corpus(self) -> list[bytes]:
        """Return the kept inputs and the seeds; the kept ones once broke a promise or reached new code."""
        kept = [path.read_bytes() for path in sorted((CORPORA / self.name).glob("*")) if path.is_file()]
        return [b"", *self.seeds(), *kept]

    def check(self, data: bytes) -> None:
        """Run one input, and see that it takes no time worth mentioning. Raises what the harness raises."""
        began_s = time.process_time()
        self.run(data)
        took_s = time.process_time() - began_s
        if took_s > LIMIT_S:
            raise SlowInputError(f"{len(data)} bytes took {took_s:.1f} s")


def load(name: str) -> Target:
    """Import a harness."""
    module = importlib.import_module(f"fuzz.harness.{name}")
    return Target(
        name,
        cast("Callable[[bytes], None]", module.run),
        cast("Callable[[], list[bytes]]", module.seeds),
    )
