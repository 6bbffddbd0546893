"""Which findings people have been told: each once, and again when it comes back."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable

from rostether.bridge.health.findings.finding import Code, Finding, Severity

FORGET_AFTER_S = 60.0
"""A finding that comes and goes with its figures is one; after a minute without it, it is news again."""

MAX_KEYS = 256
"""Subjects are names that a board chose; forgetting the oldest keeps a hostile one from filling memory."""


class FindingLedger:
    """What has been told of one board."""

    def __init__(self) -> None:
        self._told: OrderedDict[tuple[Code, str], tuple[Severity, float]] = OrderedDict()

    def news(self, findings: Iterable[Finding], now_s: float) -> list[Finding]:
        """Return the findings to tell now, of those that stand now."""
        news = []
        for finding in findings:
            severity, seen_s = self._told.get(finding.key, (None, 0.0))
            if severity is None or now_s - seen_s > FORGET_AFTER_S or finding.severity > severity:
                news.append(finding)
            self._told[finding.key] = finding.severity, now_s
            self._told.move_to_end(finding.key)
        while len(self._told) > MAX_KEYS:
            self._told.popitem(last=False)
        return news

    def forget(self, *codes: Code) -> None:
        """Let the next finding of these codes be news: its cause was gone for certain."""
        for key in [key for key in self._told if key[0] in codes]:
            del self._told[key]
