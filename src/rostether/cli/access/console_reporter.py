"""Prints the bridge's lines as rospy does, for users and scripts of serial_node.py."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from rostether.cli.shell.output import discard_output
from rostether.graph.ports import Level


class ConsoleReporter:
    """Prints `[INFO] [1700000000.123456]: text`; warnings and errors go to stderr.

    With `show_node`, a line about a board begins with its node name: one process may serve many boards.
    """

    def __init__(
        self, *, show_node: bool = True, lowest: Level = Level.INFO, clock: Callable[[], float] = time.time
    ) -> None:
        self._show_node = show_node
        self._lowest = lowest
        self._clock = clock

    def report(self, level: Level, text: str, *, node: str = "") -> None:
        """Print one line, unless its level is below `lowest`."""
        if level < self._lowest:
            return
        prefix = f"{node}: " if node and self._show_node else ""
        stream = sys.stdout if level < Level.WARN else sys.stderr
        try:
            stream.write(f"[{level.name}] [{self._clock():.6f}]: {prefix}{text}\n")
            stream.flush()
        except OSError:
            # The reader of the lines has ended (`| head`, a closed terminal); keep serving boards.
            discard_output(stream)
