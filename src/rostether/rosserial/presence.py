"""Tracks whether the device is connected and configured, with probes that only a reset board answers.

A board that has been reset sends nothing on user ids, although the host continues to send. A frame start with
a wrong version byte (`ff 00`) makes an unconfigured board request the time. A configured board ignores it,
and requests the time only every 2.5 s. Without that request, the host requests the topics: every board
answers that, even a board of protocol version 1, which ignores probes.

    state     input      next      verdict
    ABSENT    SIGN       PRESENT             a sign of a configured board: a message, an announcement
    ABSENT    EARLY      PRESENT             a time request sooner than a configured board sends one
    ABSENT    ON_TIME    PRESENT             a time request when one is due
    PRESENT   EARLY      DOUBTED   PROBE
    PRESENT   QUIET      DOUBTED   PROBE     no sign for some time
    DOUBTED   SIGN       PRESENT
    DOUBTED   QUIET      DOUBTED   PROBE
    DOUBTED   EARLY      PRESENT   RESET     it answered the probe
    DOUBTED   ON_TIME    DOUBTED   PROBE     an answer, or just the time request that was due?
    PRESENT   OVERDUE    MISSED    ASK       its time request did not come
    DOUBTED   OVERDUE    MISSED    ASK
    MISSED    SIGN       PRESENT
    MISSED    EARLY      PRESENT
    MISSED    ON_TIME    PRESENT
    PRESENT   SILENCE    ABSENT    SILENT    no answer either
    DOUBTED   SILENCE    ABSENT    SILENT
    MISSED    SILENCE    ABSENT    SILENT
"""

from __future__ import annotations

import logging
from enum import Enum, auto

_LOG = logging.getLogger(__name__)

# A reset is detected this time after the last message, so that messages continue within two seconds.
PROBE_AFTER_S = 1.0

# Probes and their answers can be lost; a probe of two bytes at this interval does no harm.
NEXT_PROBE_S = 0.4

# A configured board requests the time every 2.5 s; half a second for the jitter of networks.
EARLY_S = 2.0

# A timer that is handled this late means that this process was stopped: its intervals are wrong.
LATE_S = 0.2

# After a pause of this process of this length, its timers are handled before the data that arrived meanwhile.
PAUSED_S = 1.0

# A healthy board may be silent for 3 s: it requests the time every 2.5 s, and sketches sleep.
OVERDUE_S = 3.0

# One more second for the answers to several topic requests, in case some are lost.
SILENT_AFTER_S = 4.0

# If a configured device answers probes, each answer looks like a reset. Therefore, after each detected reset
# no other is detected for some time, which doubles up to this limit.
MAX_QUARANTINE_S = 60.0


class State(Enum):
    """The states of a device."""

    ABSENT = auto()
    PRESENT = auto()
    DOUBTED = auto()
    MISSED = auto()


class Input(Enum):
    """The inputs of the state table."""

    SIGN = auto()
    EARLY = auto()
    ON_TIME = auto()
    QUIET = auto()
    OVERDUE = auto()
    SILENCE = auto()


class Verdict(Enum):
    """The actions: send a probe, request topics, report a reset, report silence."""

    PROBE = auto()
    ASK = auto()
    RESET = auto()
    SILENT = auto()


# All other pairs change nothing.
TRANSITIONS: dict[tuple[State, Input], tuple[State, Verdict | None]] = {
    (State.ABSENT, Input.SIGN): (State.PRESENT, None),
    (State.ABSENT, Input.EARLY): (State.PRESENT, None),
    (State.ABSENT, Input.ON_TIME): (State.PRESENT, None),
    (State.PRESENT, Input.EARLY): (State.DOUBTED, Verdict.PROBE),
    (State.PRESENT, Input.QUIET): (State.DOUBTED, Verdict.PROBE),
    (State.PRESENT, Input.OVERDUE): (State.MISSED, Verdict.ASK),
    (State.PRESENT, Input.SILENCE): (State.ABSENT, Verdict.SILENT),
    (State.DOUBTED, Input.SIGN): (State.PRESENT, None),
    (State.DOUBTED, Input.QUIET): (State.DOUBTED, Verdict.PROBE),
    (State.DOUBTED, Input.EARLY): (State.PRESENT, Verdict.RESET),
    (State.DOUBTED, Input.ON_TIME): (State.DOUBTED, Verdict.PROBE),
    (State.DOUBTED, Input.OVERDUE): (State.MISSED, Verdict.ASK),
    (State.DOUBTED, Input.SILENCE): (State.ABSENT, Verdict.SILENT),
    (State.MISSED, Input.SIGN): (State.PRESENT, None),
    (State.MISSED, Input.EARLY): (State.PRESENT, None),
    (State.MISSED, Input.ON_TIME): (State.PRESENT, None),
    (State.MISSED, Input.SILENCE): (State.ABSENT, Verdict.SILENT),
}

# The duration of a state until QUIET.
_PATIENCE_S = {
    State.PRESENT: PROBE_AFTER_S,
    State.DOUBTED: NEXT_PROBE_S,
}


class Presence:
    """Tracks the presence of one device from its received frames and their times; `name` is for the log."""

    def __init__(self, name: str = "") -> None:
        self.state = State.ABSENT
        self._name = name
        self.received_at_s = 0.0
        self._changed_s = 0.0
        self._time_request_s = float("-inf")
        self._alarms = 0
        self._quarantine_until_s = float("-inf")
        self._due_s = float("inf")
        self._stalled_s = float("-inf")

    @property
    def is_certain(self) -> bool:
        """Whether the device is present and there is no sign of a reset."""
        return self.state is State.PRESENT

    def frame_received(self, now_s: float) -> None:
        """Handle any valid frame."""
        self._note_stall(now_s)
        self.received_at_s = now_s

    def message_received(self, now_s: float) -> None:
        """Handle a message on an announced id: only a configured board sends one."""
        self._alarms = 0
        self.sign_received(now_s)

    def sign_received(self, now_s: float) -> None:
        """Handle another sign of a configured board."""
        self.received_at_s = now_s
        if self.state is not State.PRESENT:
            self._step(Input.SIGN, now_s)
        self._changed_s = now_s

    def answer_received(self, now_s: float, *, is_timely: bool = True) -> None:
        """Handle the time request that answers a topic request; `is_timely`: it was not delayed."""
        if is_timely:
            self._time_request_s = now_s
        self.sign_received(now_s)

    def time_request_received(self, now_s: float, *, may_be_early: bool = False) -> Verdict | None:
        """Handle a time request; return the action that is due, if any.

        `may_be_early`: an early one is not a sign of a reset, because it answers a topic request.
        """
        self.received_at_s = now_s
        # After a pause of this process, a request that waited seems late, and the next one early.
        is_measured = now_s - self._stalled_s >= EARLY_S
        is_early = now_s - self._time_request_s < EARLY_S and is_measured and not may_be_early
        self._time_request_s = now_s
        if now_s < self._quarantine_until_s:
            self.sign_received(now_s)
            return None
        verdict = self._step(Input.EARLY if is_early else Input.ON_TIME, now_s)
        if verdict is Verdict.RESET:
            self._quarantine_until_s = now_s + min(2.0**self._alarms - 1, MAX_QUARANTINE_S)
            self._alarms = min(self._alarms + 1, 16)
        return verdict

    def get_timer(self, *, probes: bool) -> float | None:
        """Return when to call `handle_timer`, None if absent; `probes`: the device may be asked now."""
        if self.state is State.ABSENT:
            self._due_s = float("inf")
            return None
        silent_s = self.received_at_s + SILENT_AFTER_S
        if not probes or self.state is State.MISSED:
            self._due_s = silent_s
        else:
            self._due_s = min(
                silent_s, self.received_at_s + OVERDUE_S, self._changed_s + _PATIENCE_S[self.state]
            )
        return self._due_s

    def handle_timer(self, now_s: float, *, probes: bool) -> Verdict | None:
        """Return the action that is due now, None if there is none."""
        late_s = now_s - self._due_s
        self._note_stall(now_s)
        if self.state is State.ABSENT:
            return None
        if late_s > PAUSED_S:
            self.received_at_s = self._changed_s = now_s
            return None
        if now_s >= self.received_at_s + SILENT_AFTER_S:
            return self._step(Input.SILENCE, now_s)
        if not probes or self.state is State.MISSED:
            return None
        if now_s >= self.received_at_s + OVERDUE_S:
            return self._step(Input.OVERDUE, now_s)
        if now_s >= self._changed_s + _PATIENCE_S[self.state]:
            return self._step(Input.QUIET, now_s)
        return None

    def _note_stall(self, now_s: float) -> None:
        if now_s > self._due_s + LATE_S:
            self._stalled_s = now_s
            self._due_s = float("inf")

    def _step(self, what: Input, now_s: float) -> Verdict | None:
        before = self.state
        self.state, verdict = TRANSITIONS.get((before, what), (before, None))
        self._changed_s = now_s
        if self.state is not before:
            _LOG.debug("%s: presence %s -> %s (%s)", self._name, before.name, self.state.name, what.name)
        return verdict
