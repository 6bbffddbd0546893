"""Commands in processes of their own, for what signals and pipes do to them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def started(
    master_uri: str, *arguments: str, ignores_sigint: bool = False
) -> Iterator[subprocess.Popen[str]]:
    """Run a command in a process of its own."""

    def ignore() -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    process = subprocess.Popen(
        [sys.executable, "-m", "rostether", *arguments],
        env={**os.environ, "ROS_MASTER_URI": master_uri},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=ignore if ignores_sigint else None,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def read_until(process: subprocess.Popen[str], text: str) -> list[str]:
    """Return the lines of stdout up to the one that holds a text; fails when the process ends before."""
    assert process.stdout is not None
    lines = []
    for line in process.stdout:
        lines.append(line.rstrip("\n"))
        if text in line:
            return lines
    raise AssertionError(f"it never printed {text!r}: {lines}")
