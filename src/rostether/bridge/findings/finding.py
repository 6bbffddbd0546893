"""A finding: a problem of a board's line in plain words, and the next step."""

from __future__ import annotations

from enum import IntEnum, StrEnum

from msgspec import Struct


class Severity(IntEnum):
    """The severity, with the values of diagnostic_msgs/DiagnosticStatus."""

    WARN = 1
    ERROR = 2


class Code(StrEnum):
    """The kind of a finding; scripts use these, so they never change."""

    NO_PORT = "no-port"
    NOT_A_PORT = "not-a-port"
    NO_PERMISSION = "no-permission"
    BUSY = "busy"
    CANNOT_OPEN = "cannot-open"
    NOBODY_CONNECTED = "nobody-connected"
    CONNECTION_LOST = "connection-lost"
    NOTHING_RECEIVED = "nothing-received"
    TEXT_RECEIVED = "text-received"
    WRONG_BAUD = "wrong-baud"
    NOISE_RECEIVED = "noise-received"
    PROTOCOL_VERSION = "protocol-version"
    BOARD_SILENT = "board-silent"
    TEXT_BETWEEN_FRAMES = "text-between-frames"
    FRAMES_DAMAGED = "frames-damaged"
    RESET_LOOP = "reset-loop"
    RAM_OVERFLOW = "ram-overflow"
    STALE_HEADERS = "stale-headers"
    UNKNOWN_TYPE = "unknown-type"
    NOT_BRIDGED = "not-bridged"
    MESSAGES_TOO_LONG = "messages-too-long"
    MESSAGES_MISFIT = "messages-misfit"
    UNANNOUNCED_MESSAGES = "unannounced-messages"
    BUFFER_TOO_SMALL = "buffer-too-small"
    MESSAGES_LOST = "messages-lost"
    SLOW_LOOP = "slow-loop"
    CLOCK_DRIFT = "clock-drift"
    RADIO_LOSS = "radio-loss"
    MISSING_TOPIC = "missing-topic"


class Finding(Struct, frozen=True):
    """One problem; `subject` distinguishes findings with the same code (a topic, a type), else it is empty.

    `seen` and `next_step` are one line each, without a full stop. `is_reported`: it was already reported.
    """

    code: Code
    severity: Severity
    seen: str
    next_step: str
    subject: str = ""
    is_reported: bool = False

    @property
    def key(self) -> tuple[Code, str]:
        """The identity of the finding, while the figures in its text change."""
        return self.code, self.subject

    def __str__(self) -> str:
        """Return the one line that logs show."""
        return f"{self.seen}; {self.next_step}"


def split_step(text: str, default: str) -> tuple[str, str]:
    """Return the problem and the next step in the text of an error; `default` if it has no step."""
    problem, _, step = text.rpartition("; ")
    return (problem, step) if problem else (text, default)


def error(code: Code, seen: str, next_step: str, subject: str = "", *, is_reported: bool = False) -> Finding:
    """Return a finding that stops messages."""
    return Finding(code, Severity.ERROR, seen, next_step, subject, is_reported)


def warning(
    code: Code, seen: str, next_step: str, subject: str = "", *, is_reported: bool = False
) -> Finding:
    """Return a finding that does not stop messages."""
    return Finding(code, Severity.WARN, seen, next_step, subject, is_reported)
