"""A board's diagnostic_msgs/DiagnosticStatus: what rqt_robot_monitor and diagnostic_aggregator show."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence

from rostether.bridge.board_node import BoardNode
from rostether.bridge.findings.finding import Finding, Severity
from rostether.bridge.health.board_status import STATUS_SUFFIX, UNKNOWN
from rostether.bridge.health.diagnostics import BoardView
from rostether.bridge.reporter import shown_line
from rostether.transports.link_quality import LinkQuality

_OK = 0

# The rate of a topic at 1 Hz is steady over this time, and shows a change within a few seconds.
WINDOW_S = 5.0


class StatusWriter:
    """Writes the status of one board, once a second."""

    def __init__(self) -> None:
        self._rates = Rates()

    def array(
        self, node: BoardNode, view: BoardView, findings: Sequence[Finding], now_s: float
    ) -> dict[str, object]:
        """Return the DiagnosticArray's fields; its stamp is the graph's time."""
        status = {
            "level": _level(view, findings),
            "name": f"{view.node.lstrip('/')}{STATUS_SUFFIX}",
            "message": _message(view, findings),
            "hardware_id": node.hardware_id,
            "values": [
                {"key": shown_line(key), "value": shown_line(value)}
                for key, value in self._values(node, view, findings, now_s)
            ],
        }
        return {"header": {"stamp": node.graph.now()}, "status": [status]}

    def _values(
        self, node: BoardNode, view: BoardView, findings: Sequence[Finding], now_s: float
    ) -> Iterator[tuple[str, str]]:
        counts = {"received": view.received_bytes, "sent": view.sent_bytes}
        names = [f"{each.role} {each.name}" for each in view.endpoints]
        counts |= {name: each.message_count for name, each in zip(names, view.endpoints, strict=True)}
        rates = self._rates.update(counts, now_s)
        health = node.health
        watch = health.watch
        late_s = watch.loop_speed.late_s if watch is not None else None
        connected_s = now_s - health.connected_at_s if view.is_connected else None
        yield "state", state_of(view)
        yield "peer", view.peer
        yield "connected [s]", _scaled(connected_s, 1, ".0f")
        yield "protocol version", str(view.protocol_version or UNKNOWN)
        if view.baud is not None:
            yield "baud rate", str(view.baud)
        yield "received [bytes]", str(view.received_bytes)
        yield "received [bytes/s]", f"{rates.get('received', 0.0):.0f}"
        yield "sent [bytes]", str(view.sent_bytes)
        yield "sent [bytes/s]", f"{rates.get('sent', 0.0):.0f}"
        yield "queued [bytes]", str(view.queued_bytes)
        yield "frames", str(view.received_frames)
        yield "checksum errors", str(view.damaged_frames)
        yield "discarded [bytes]", str(view.discarded_bytes)
        yield "resets", str(view.reset_count)
        yield "reconnects", str(max(0, health.connection_count - 1))
        yield "round trip [ms]", _scaled(view.round_trip_s, 1e3, ".1f")
        yield "clock offset [ms]", _scaled(health.clock.offset_s(view.round_trip_s), 1e3, "+.1f")
        yield "clock drift [ppm]", _scaled(health.clock.drift_ppm, 1, "+.0f")
        yield "loop late [ms]", _scaled(late_s, 1e3, ".0f")
        if health.radio is not None:
            yield from _radio_values(health.radio)
        if (program := node.program) is not None:
            yield "flash [bytes]", str(program.flash_bytes)
            yield "flash limit [bytes]", str(program.flash_limit_bytes or UNKNOWN)
            yield "RAM [bytes]", str(program.ram_bytes)
            yield "RAM limit [bytes]", str(program.ram_limit_bytes or UNKNOWN)
        for name, endpoint in zip(names, view.endpoints, strict=True):
            yield f"{name} type", endpoint.type
            yield f"{name} [messages]", str(endpoint.message_count)
            yield f"{name} [Hz]", f"{rates.get(name, 0.0):.1f}"
            yield f"{name} dropped", str(endpoint.dropped_count)
            yield f"{name} buffer [bytes]", str(endpoint.buffer_bytes)
            if endpoint.misfit_count:
                yield f"{name} misfit", str(endpoint.misfit_count)
        for finding in findings:
            yield f"finding {finding.code}", str(finding)


def _radio_values(radio: LinkQuality) -> Iterator[tuple[str, str]]:
    yield "signal [dBm]", _scaled(radio.rssi_dbm, 1, ".0f")
    yield "radio packets received", str(radio.received_packets)
    yield "radio packets sent", str(radio.sent_packets)
    yield "radio packets lost", str(radio.lost_packets)
    yield "radio retries", _scaled(radio.retries, 1, ".0f")
    yield "last radio packet", radio.last_status


def state_of(view: BoardView) -> str:
    """Return the state of a board's connection in one or two words."""
    if not view.is_connected:
        return "disconnected"
    if view.protocol_version is None:
        return "no answer"
    return "connected" if view.is_settled else "negotiating"


def _level(view: BoardView, findings: Sequence[Finding]) -> int:
    if not view.is_connected:
        return Severity.ERROR
    return max((each.severity for each in findings), default=_OK)


def _message(view: BoardView, findings: Sequence[Finding]) -> str:
    if not view.is_connected:
        return "not connected"
    if findings:
        more = f" (and {len(findings) - 1} more)" if len(findings) > 1 else ""
        return shown_line(findings[0].seen) + more
    return "no problem found" if view.is_settled else state_of(view)


def _scaled(value: float | None, factor: float, form: str) -> str:
    return UNKNOWN if value is None else format(value * factor, form)


class Rates:
    """The growth of counters over the last few updates."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, dict[str, int]]] = deque()

    def update(self, counts: Mapping[str, int], now_s: float) -> dict[str, float]:
        """Read the counters and return their growth per second; empty at the first call.

        A counter that is lower than before belongs to a new connection and started from zero.
        """
        self._samples.append((now_s, dict(counts)))
        while len(self._samples) > 2 and now_s - self._samples[0][0] > WINDOW_S:
            self._samples.popleft()
        before_s, before = self._samples[0]
        span_s = now_s - before_s
        if span_s <= 0:
            return {}
        return {
            key: (count - before[key] if count >= before.get(key, 0) and key in before else count) / span_s
            for key, count in counts.items()
        }
