"""The targets by name, their corpora, and running one input."""

from __future__ import annotations

import importlib
import random
import sys
import time
import tracemalloc
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from fuzz.mutations import mutated

NAMES = (
    "frame_decoder",
    "packets",
    "host_link",
    "device_link",
    "session",
    "tcpros",
    "xmlrpc",
    "http",
    "definitions",
    "cdr",
    "yaml_form",
    "devices_toml",
    "address",
    "psk_hello",
    "xbee",
    "recordings",
    "rosbridge",
    "foxglove",
)
CORPORA = Path(__file__).parent / "corpora"
# No input of a few KB may block a bridge for as long as a board waits for its parameter.
LIMIT_S = 1.0
# The memory for one input: 2000 times the longest input, and far below the 256 MB that an input may declare.
LIMIT_BYTES = 32 << 20
# Tracing memory takes three times as long, so only one of this number of inputs is traced.
TRACE_EVERY = 16
_DESCRIPTORS = Path("/proc/self/fd")


class SlowInputError(Exception):
    """An input took longer than the limit for its size."""


class LargeInputError(Exception):
    """An input needed more memory than the limit for its size."""


class LeftOpenError(Exception):
    """An input left a file or a socket open, or an exception that was not handled."""


@dataclass(frozen=True, slots=True)
class Target:
    """One harness: `run` raises if a promise is broken, `seeds` are valid inputs.

    `generate` creates an input with the grammar of the target, so that deep states are reached.
    """

    name: str
    run: Callable[[bytes], None]
    seeds: Callable[[], list[bytes]]
    generate: Callable[[random.Random], bytes]

    def corpus(self) -> list[bytes]:
        """Return the seeds and the kept inputs, which once broke a promise or reached new code."""
        kept = [path.read_bytes() for path in sorted((CORPORA / self.name).glob("*")) if path.is_file()]
        return [b"", *self.seeds(), *kept]

    def inputs(self, seed: int) -> Iterator[bytes]:
        """Yield inputs without end, from the grammar and by random changes; the same for the same seed."""
        return mutated(self.corpus(), seed, self.generate)

    def check(self, data: bytes, *, is_traced: bool = False) -> None:
        """Run one input, and check that it uses little time and memory, and leaves no descriptor open.

        `is_traced`: its memory is measured, which is slow. Raises the errors of the harness.
        """
        began_s = time.process_time()
        with _nothing_left_open():
            if is_traced:
                self._run_traced(data)
            else:
                self.run(data)
        took_s = time.process_time() - began_s
        if took_s > LIMIT_S * (3 if is_traced else 1):
            raise SlowInputError(f"{len(data)} bytes took {took_s:.1f} s")

    def _run_traced(self, data: bytes) -> None:
        tracemalloc.start()
        try:
            self.run(data)
            peak_bytes = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        if peak_bytes > LIMIT_BYTES:
            raise LargeInputError(f"{len(data)} bytes took {peak_bytes} bytes of memory")


@contextmanager
def _nothing_left_open() -> Iterator[None]:
    """Check that no more descriptors are open than before, and that no exception was ignored."""
    unseen: list[str] = []
    before, hook = _open_descriptors(), sys.unraisablehook
    sys.unraisablehook = lambda failure: unseen.append(repr(failure.exc_value))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", ResourceWarning)
            yield
    finally:
        sys.unraisablehook = hook
    left = _open_descriptors() - before
    if left > 0 or unseen:
        raise LeftOpenError(f"{left} descriptors were left open; {'; '.join(unseen) or 'no exceptions'}")


def _open_descriptors() -> int:
    return sum(1 for _ in _DESCRIPTORS.iterdir()) if _DESCRIPTORS.is_dir() else 0


def load(name: str) -> Target:
    """Import a harness."""
    module = importlib.import_module(f"fuzz.harness.{name}")
    return Target(
        name,
        cast("Callable[[bytes], None]", module.run),
        cast("Callable[[], list[bytes]]", module.seeds),
        cast("Callable[[random.Random], bytes]", module.generate),
    )
