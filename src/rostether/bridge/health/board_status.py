"""Reads the figures of boards from /diagnostics."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from msgspec import Struct

from rostether.mechanisms.text import fold_line

TOPIC = "/diagnostics"
TYPE = "diagnostic_msgs/DiagnosticArray"

# The end of the names of boards' entries.
STATUS_SUFFIX = ": rosserial"
# The text of a figure that is not known.
UNKNOWN = "unknown"
_TOPIC_ROLES = ("publisher", "subscriber")
_SERVICE_ROLES = ("service server", "service client")


class EndpointStatus(Struct, frozen=True):
    """One topic or service of a board; `dropped_count` messages were lost."""

    role: str
    name: str
    type: str
    message_count: int
    rate_hz: float
    dropped_count: int

    @property
    def is_topic(self) -> bool:
        """Whether it is a topic, not a service."""
        return self.role in _TOPIC_ROLES


class BoardStatus(Struct, frozen=True):
    """One board; unknown figures are None, texts are one line without control characters."""

    name: str
    state: str
    level: int
    message: str
    peer: str
    connected_s: float | None
    received_bytes: int
    received_bytes_s: float
    sent_bytes: int
    sent_bytes_s: float
    checksum_errors: int
    resets: int
    reconnects: int
    round_trip_ms: float | None
    clock_offset_ms: float | None
    clock_drift_ppm: float | None
    endpoints: tuple[EndpointStatus, ...]
    findings: tuple[str, ...]

    @property
    def dropped_count(self) -> int:
        """How many messages of all topics were lost."""
        return sum(each.dropped_count for each in self.endpoints)


def read_statuses(array: Any) -> list[BoardStatus]:
    """Return the boards of a diagnostic_msgs/DiagnosticArray, without the entries of other programs."""
    return [
        _read(status)
        for status in array.status
        if status.name.endswith(STATUS_SUFFIX) and any(each.key == "state" for each in status.values)
    ]


def _read(status: Any) -> BoardStatus:
    values = {fold_line(each.key): fold_line(each.value) for each in status.values}
    return BoardStatus(
        name="/" + fold_line(status.name.removesuffix(STATUS_SUFFIX)),
        state=values["state"],
        level=int(status.level),
        message=fold_line(status.message),
        peer=values.get("peer", ""),
        connected_s=_number(values, "connected [s]"),
        received_bytes=_count(values, "received [bytes]"),
        received_bytes_s=_number(values, "received [bytes/s]") or 0.0,
        sent_bytes=_count(values, "sent [bytes]"),
        sent_bytes_s=_number(values, "sent [bytes/s]") or 0.0,
        checksum_errors=_count(values, "checksum errors"),
        resets=_count(values, "resets"),
        reconnects=_count(values, "reconnects"),
        round_trip_ms=_number(values, "round trip [ms]"),
        clock_offset_ms=_number(values, "clock offset [ms]"),
        clock_drift_ppm=_number(values, "clock drift [ppm]"),
        endpoints=tuple(_endpoints(values)),
        findings=tuple(value for key, value in values.items() if key.startswith("finding ")),
    )


def _endpoints(values: dict[str, str]) -> Sequence[EndpointStatus]:
    found = []
    for key in values:
        title = key.removesuffix(" [messages]")
        role = next((each for each in _TOPIC_ROLES + _SERVICE_ROLES if title.startswith(f"{each} ")), None)
        if title == key or role is None:
            continue
        found.append(
            EndpointStatus(
                role,
                title.removeprefix(f"{role} "),
                values.get(f"{title} type", ""),
                _count(values, key),
                _number(values, f"{title} [Hz]") or 0.0,
                _count(values, f"{title} dropped"),
            )
        )
    return found


def _number(values: dict[str, str], key: str) -> float | None:
    text = values.get(key, UNKNOWN)
    try:
        return None if text == UNKNOWN else float(text)
    except ValueError:
        return None


def _count(values: dict[str, str], key: str) -> int:
    return round(_number(values, key) or 0)
