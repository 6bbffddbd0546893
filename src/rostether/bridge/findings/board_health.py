"""The health of one board over all its connections: findings, which of them were reported, and the clock."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Iterator

from rostether.bridge.endpoint.table import EndpointTable
from rostether.bridge.findings.endpoint_findings import EndpointFindings
from rostether.bridge.findings.finding import Code, Finding, Severity, warning
from rostether.bridge.findings.line_watch import LineWatch
from rostether.bridge.findings.medium import Medium
from rostether.bridge.findings.required import RequiredTopics
from rostether.bridge.findings.resets import Resets
from rostether.bridge.reporter import Notices
from rostether.errors import PeerClosedError, TransportError
from rostether.graph.ports import Level
from rostether.rosserial.clock_estimate import ClockEstimate
from rostether.rosserial.link_statistics import LinkStatistics
from rostether.serde.store import TypeStore
from rostether.transports.link_quality import LinkQuality

# 5 ms between two time answers. Crystals drift by up to 100 ppm, resonators of small boards by up to 5000.
DRIFT_PPM = 2000

# A radio has repeated each lost packet several times, so a link with fewer losses is still usable.
MUCH_RADIO_LOSS = 0.1

_LEVELS = {Severity.WARN: Level.WARN, Severity.ERROR: Level.ERROR}

# A finding that comes and goes is reported once; after a minute without it, it is reported again.
FORGET_AFTER_S = 60.0

# Boards choose the subjects; dropping the oldest keys keeps a hostile board from filling the memory.
MAX_KEYS = 256


class BoardHealth:
    """The health of one board's node."""

    def __init__(
        self, endpoints: EndpointTable, store: TypeStore, notices: Notices, required: RequiredTopics
    ) -> None:
        self.clock = ClockEstimate()
        self.connection_count = 0
        self.connected_at_s = 0.0
        self.watch: LineWatch | None = None
        # None if the board is not on a radio.
        self.radio: LinkQuality | None = None
        self.required = required
        self._notices = notices
        self._resets = Resets()
        self._was_closed = False
        self._ledger = FindingLedger()
        self._endpoints = EndpointFindings(endpoints, store)

    def connected(
        self, baud: int | None, statistics: LinkStatistics, now_s: float, medium: Medium = Medium.SERIAL
    ) -> LineWatch:
        """Watch a new connection; return its watch."""
        was_alive = self.watch is not None and self.watch.was_alive
        if self._was_closed:
            self._resets = Resets()
        elif self.connection_count and was_alive:
            # The port of a board with built-in USB disappears when the board resets.
            self._resets.record(now_s, was_gone=medium is Medium.SERIAL)
        self.connection_count += 1
        self.connected_at_s = now_s
        self.clock.forget()
        self.required.forget()
        medium = medium if self.radio is None else Medium.RADIO
        self.watch = LineWatch(baud, self._resets, statistics, now_s, medium=medium)
        return self.watch

    def disconnected(self, error: TransportError | None, *, is_program: bool = False) -> None:
        """Record how a connection ended, because a board that resets loses it, while a program closes it.

        `is_program`: the connection is from this machine. It then does not count as lost, because a killed
        program ends it in the same way as a board.
        """
        self._was_closed = is_program or isinstance(error, PeerClosedError)

    def find(self, now_s: float) -> list[Finding]:
        """Return the current findings, errors first. Called about once a second."""
        if self.watch is None:
            return []
        found = self.watch.find(now_s)
        found += self._endpoints.find(now_s, self.watch.too_large_s, self.watch.oversizes)
        found += self.required.find()
        # A board that is off or out of range has its own finding.
        if self.radio is not None and not self.watch.is_silent:
            found += _radio_loss(self.radio)
        found += _drift(self.clock.drift_ppm)
        return sorted(found, key=lambda each: -each.severity)

    def report(self, findings: list[Finding], now_s: float) -> None:
        """Report each finding once, in one line."""
        for finding in self._ledger.due(findings, now_s):
            if not finding.is_reported:
                self._notices.report(_LEVELS[finding.severity], str(finding))


def _radio_loss(radio: LinkQuality) -> Iterator[Finding]:
    loss = radio.recent_loss
    if loss is not None and loss >= MUCH_RADIO_LOSS:
        signal = "" if radio.rssi_dbm is None else f", signal {radio.rssi_dbm} dBm"
        yield warning(
            Code.RADIO_LOSS,
            f"{100 * loss:.0f} % of the last {radio.recent_packets} radio packets to the board were lost "
            f"({radio.last_loss}{signal})",
            "move the radios closer together, or set all of them to another channel",
        )


def _drift(drift_ppm: float | None) -> Iterator[Finding]:
    if drift_ppm is not None and abs(drift_ppm) >= DRIFT_PPM:
        yield warning(
            Code.CLOCK_DRIFT,
            f"the board's clock runs {abs(drift_ppm):.0f} ppm too {'fast' if drift_ppm > 0 else 'slow'}: its "
            f"time stamps jump by {abs(drift_ppm) * 2.5e-3:.1f} ms each time it requests the time",
            "use a board with a crystal, or stamp messages on the host if milliseconds matter",
        )


class FindingLedger:
    """The reported findings of one board."""

    def __init__(self) -> None:
        self._reported: OrderedDict[tuple[Code, str], tuple[Severity, float]] = OrderedDict()

    def due(self, findings: Iterable[Finding], now_s: float) -> list[Finding]:
        """Return the current findings that should be reported now."""
        due = []
        for finding in findings:
            severity, seen_s = self._reported.get(finding.key, (None, 0.0))
            if severity is None or now_s - seen_s > FORGET_AFTER_S or finding.severity > severity:
                due.append(finding)
            self._reported[finding.key] = finding.severity, now_s
            self._reported.move_to_end(finding.key)
        while len(self._reported) > MAX_KEYS:
            self._reported.popitem(last=False)
        return due
