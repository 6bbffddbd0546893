"""Reports of the bridge: lines, and one line per episode for problems that could repeat endlessly."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeAlias

from rostether.errors import RostetherError
from rostether.graph.ports import Level, Report
from rostether.mechanisms.rate_limits import LineBudget, RepeatLimiter
from rostether.mechanisms.text import counted, escape_line

# The length of a line on a terminal; longer log text of a board is complete only in the graph.
MAX_LINE_CHARS = 500

LineText: TypeAlias = str | Callable[[], str]


class Reporter(Protocol):
    """Receives the bridge's reports to users; a command line prints them."""

    def report(self, level: Level, text: str, *, node: str = "") -> None:
        """Show one line; `node` is the board's node name, empty for the bridge itself."""


class SilentReporter:
    """A reporter without output."""

    def report(self, level: Level, text: str, *, node: str = "") -> None:
        """Drop the line."""


class LimitedReporter:
    """Passes on a limited number of lines: for lines that remote peers can cause."""

    def __init__(self, reporter: Reporter, clock: Callable[[], float]) -> None:
        self._reporter = reporter
        self._clock = clock
        self._budget = LineBudget()

    def report(self, level: Level, text: str, *, node: str = "") -> None:
        """Show one line, or count it."""
        omitted_count = self._budget.admit(self._clock())
        if omitted_count is None:
            return
        if omitted_count:
            self._reporter.report(Level.WARN, f"omitted {counted(omitted_count, 'line')} like the next one")
        self._reporter.report(level, shown_line(text), node=node)


def shown_line(text: str) -> str:
    """Return the text as one line that cannot control a terminal, cut at MAX_LINE_CHARS."""
    return escape_line(text.rstrip("\r\n"), MAX_LINE_CHARS)


def reason_of(error: Exception) -> str:
    """Return the text to report for an error; if the error is unexpected, the text asks to report it."""
    if isinstance(error, RostetherError):
        return str(error)
    return f"{type(error).__name__}: {error}; please report it"


class Notices:
    """The lines of one board: to the reporter, and to the graph's log once the board has a node there."""

    def __init__(self, reporter: Reporter, node: str, clock: Callable[[], float]) -> None:
        self.node = node
        self.to_graph: Report | None = None
        self._reporter = reporter
        self._clock = clock
        self._episodes = RepeatLimiter(by_episode=True)

    def report(self, level: Level, text: str) -> None:
        """Report a line."""
        self._reporter.report(level, shown_line(text), node=self.node)
        if self.to_graph is not None:
            self.to_graph(level, text)

    def show(self, level: Level, text: str) -> None:
        """Report a line to users only, not to the graph."""
        self._reporter.report(level, shown_line(text), node=self.node)

    def report_episode(self, kind: str, level: Level, text: LineText, *, count: int = 1) -> None:
        """Report the first line of a `kind`; drop further ones until none has come for 10 s."""
        suppressed = self._episodes.admit(kind, self._clock(), count=count)
        if suppressed is None:
            return
        line = text if isinstance(text, str) else text()
        self.report(level, f"{line} ({suppressed} more since the last such line)" if suppressed else line)

    def report_defect(self, error: Exception) -> None:
        """Report that a part of a session failed."""
        self.report_episode("defect", Level.ERROR, f"part of the session failed: {reason_of(error)}")

    def end_episode(self, kind: str) -> None:
        """Report the next line of `kind` again."""
        self._episodes.forget(kind)
