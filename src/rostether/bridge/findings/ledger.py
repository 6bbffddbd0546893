"""Stores which findings were reported: each once, and again after it returns."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable

from rostether.bridge.findings.finding import Code, Finding, Severity

# A finding that comes and goes is reported once; after a minute without it, it is reported again.
FORGET_AFTER_S = 60.0

# Boards choose the subjects; dropping the oldest keys keeps a hostile board from filling the memory.
MAX_KEYS = 256


class FindingLedger:
    """The reported findings of one board."""

    def __init__(self) -> None:
        self._reported: OrderedDict[tuple[Code, str], tuple[Severity, float]] = OrderedDict()

    def news(self, findings: Iterable[Finding], now_s: float) -> list[Finding]:
        """Return the current findings that should be reported now."""
        news = []
        for finding in findings:
            severity, seen_s = self._reported.get(finding.key, (None, 0.0))
            if severity is None or now_s - seen_s > FORGET_AFTER_S or finding.severity > severity:
                news.append(finding)
            self._reported[finding.key] = finding.severity, now_s
            self._reported.move_to_end(finding.key)
        while len(self._reported) > MAX_KEYS:
            self._reported.popitem(last=False)
        return news

    def forget(self, *codes: Code) -> None:
        """Report the next finding of these codes again, because its cause was certainly gone."""
        for key in [key for key in self._reported if key[0] in codes]:
            del self._reported[key]
