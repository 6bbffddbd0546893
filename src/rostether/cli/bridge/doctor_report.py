"""Writes a diagnosis: lines for users, records for scripts."""

from __future__ import annotations

from collections.abc import Iterator

from msgspec import to_builtins

from rostether.bridge.findings.finding import Finding, Severity
from rostether.bridge.health.board_status import BoardStatus, EndpointStatus
from rostether.bridge.health.diagnostics import EndpointView
from rostether.bridge.health.doctor import Diagnosis
from rostether.bridge.health.watching import BoardObservations
from rostether.mechanisms.text import counted

_WORDS = {Severity.WARN: "warning", Severity.ERROR: "error"}


def lines_of(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield lines for users: the port, each finding with its next step, and the board."""
    at = f" at {diagnosis.baud} baud" if diagnosis.baud else ""
    yield f"{diagnosis.address}{at}"
    for finding in diagnosis.findings:
        yield f"  {_WORDS[finding.severity]} {finding.code}: {finding.seen}"
        yield f"    next: {finding.next_step}"
    board = diagnosis.board
    if board is not None:
        yield f"  board: {_describe(board)}"
        for endpoint in board.view.endpoints:
            rate_hz = board.rate_hz(endpoint) if endpoint.role == "publisher" else None
            yield f"    {_endpoint_text(endpoint, rate_hz)}"
    if diagnosis.is_ok:
        yield "  no problem found"


def reported_lines(board: BoardStatus, master_uri: str) -> Iterator[str]:
    """Yield lines for users about a board that a running bridge reports."""
    yield f"{board.name}, on a running bridge at {master_uri}"
    for finding in board.findings:
        yield f"  {finding}"
    since = "" if board.connected_s is None else f" for {board.connected_s:.0f} s"
    yield f"  board: {board.state}{since}, {board.peer}, {counted(board.checksum_errors, 'damaged frame')}"
    for endpoint in board.endpoints:
        yield f"    {_endpoint_text(endpoint, endpoint.rate_hz if endpoint.is_topic else None)}"
    if not board.level:
        yield "  no problem found"


def reported_record(board: BoardStatus) -> dict[str, object]:
    """Return the record of a board that a running bridge reports."""
    return {"address": board.peer, "healthy": not board.level, **to_builtins(board)}


def finding_record(diagnosis: Diagnosis, finding: Finding) -> dict[str, object]:
    """Return one finding as a record for scripts."""
    return {
        "address": diagnosis.address,
        "finding": str(finding.code),
        "severity": _WORDS[finding.severity],
        "subject": finding.subject or None,
        "seen": finding.seen,
        "next_step": finding.next_step,
    }


def board_record(diagnosis: Diagnosis) -> dict[str, object]:
    """Return the last record of a diagnosis: whether the board is healthy, and its details."""
    record: dict[str, object] = {
        "address": diagnosis.address,
        "healthy": diagnosis.is_ok,
        "findings": [str(finding.code) for finding in diagnosis.findings],
        "baud": diagnosis.baud,
        "board": None,
    }
    board = diagnosis.board
    if board is not None:
        view = board.view
        record["board"] = {
            "peer": view.peer,
            "protocol_version": view.protocol_version,
            "is_settled": view.is_settled,
            "watched_s": round(board.watched_s, 3),
            "received_frames": view.received_frames,
            "damaged_frames": view.damaged_frames,
            "reset_count": view.reset_count,
            "round_trip_ms": _scaled(view.round_trip_s, 1e3),
            "clock_offset_ms": _scaled(board.clock_offset_s, 1e3),
            "clock_drift_ppm": _scaled(board.clock_drift_ppm, 1),
            "endpoints": [_endpoint_record(board, endpoint) for endpoint in view.endpoints],
        }
    return record


def _endpoint_record(board: BoardObservations, endpoint: EndpointView) -> dict[str, object]:
    return {
        "role": endpoint.role,
        "name": endpoint.name,
        "type": endpoint.type,
        "topic_id": endpoint.topic_id,
        "buffer_bytes": endpoint.buffer_bytes,
        "message_count": endpoint.message_count,
        "rate_hz": round(board.rate_hz(endpoint), 3),
    }


def _describe(board: BoardObservations) -> str:
    view = board.view
    parts = [f"protocol version {view.protocol_version}", counted(view.received_frames, "frame")]
    parts.append(f"{view.damaged_frames} damaged")
    if view.round_trip_s is not None:
        parts.append(f"round trip {view.round_trip_s * 1e3:.1f} ms")
    if board.clock_offset_s is not None:
        parts.append(f"clock {board.clock_offset_s * 1e3:+.1f} ms")
    if board.clock_drift_ppm is not None:
        parts.append(f"drift {board.clock_drift_ppm:+.0f} ppm")
    return f"{', '.join(parts)}; watched for {board.watched_s:.0f} s"


def _endpoint_text(endpoint: EndpointView | EndpointStatus, rate_hz: float | None) -> str:
    rate = "" if rate_hz is None else f", {rate_hz:.1f} Hz"
    return f"{endpoint.role} {endpoint.name} [{endpoint.type}]{rate}"


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else round(value * factor, 3)
