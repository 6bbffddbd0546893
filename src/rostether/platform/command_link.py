"""The sender and the receiver of framed commands, without sockets or clocks.

A sender repeats its state, so that a lost datagram costs only 50 ms. A receiver obeys one sender at
a time, and stops when the time to live of the last command has passed since its receipt.
"""

from __future__ import annotations

from msgspec import Struct

from rostether.errors import RemoteProtocolError
from rostether.platform.command_frame import (
    ALL_GROUPS,
    DEFAULT_TTL_MS,
    NO_KEY,
    CommandFrame,
    Flags,
    decode_frame,
)
from rostether.platform.status_frame import Refusal

# The interval between repetitions of a command: a robot that misses one moves 50 ms longer.
REPEAT_S = 0.05

# A stop is sent for 0.2 s, faster than commands: Wi-Fi rarely loses all of these frames.
_STOP_PERIOD_S = 0.02
_STOP_FRAMES = 10

# After a lost release, the robot is free when its time to live has passed.
RELEASE_FRAMES = 3

# A changed command is sent three times immediately, unless a change was sent three times within `REPEAT_S`.
_CHANGE_FRAMES = 3

_LAST_SEQUENCE = 0xFFFF_FFFF
# A frame moves a robot only if ARMED is the only one of these flags that it has.
_MOTION = Flags.ARMED | Flags.STOP | Flags.RELEASE


class SenderSettings(Struct, frozen=True):
    """The target and the type of commands: `target` is a robot's id, or with `to_groups` a mask of groups."""

    target: int = ALL_GROUPS
    to_groups: bool = True
    kind: bytes = bytes(4)
    ttl_ms: int = DEFAULT_TTL_MS
    key: bytes = NO_KEY


class CommandSender:
    """Makes the datagrams of one sender; `epoch_us` is its start, in microseconds since 1970."""

    def __init__(self, settings: SenderSettings, epoch_us: int) -> None:
        self._settings = settings
        self.epoch_us = epoch_us
        # The sequence number of the last frame, 0 before the first.
        self.sequence = 0
        self._payload: bytes | None = None
        self._stops_left = 0
        self._stop_flags = Flags.STOP
        # When to call `repeat` next; None until the next command or stop.
        self.due_s: float | None = None
        self._copied_s = float("-inf")

    def command(self, payload: bytes, now_s: float) -> list[bytes]:
        """Return the datagrams of a command: three if it differs from the last one, else one.

        If commands change faster than every `REPEAT_S`, only some are sent three times: the next command
        replaces them.
        """
        count = 1
        if payload != self._payload and now_s - self._copied_s >= REPEAT_S:
            count = _CHANGE_FRAMES
            self._copied_s = now_s
        self._payload = payload
        self._stops_left = 0
        self.due_s = now_s + REPEAT_S
        return [self._frame(Flags.ARMED, payload) for _ in range(count)]

    def stop(self, now_s: float) -> list[bytes]:
        """Stop the robots of all senders: return the first datagram; `repeat` returns the others."""
        return self._end_motion(Flags.STOP, now_s)

    def halt(self, now_s: float) -> list[bytes]:
        """Stop only the robots that obey this sender: return the first datagram, like `stop`."""
        return self._end_motion(Flags(0), now_s)

    def repeat(self, now_s: float) -> list[bytes]:
        """Return the datagrams to repeat now."""
        if self._stops_left:
            self._stops_left -= 1
            self.due_s = now_s + _STOP_PERIOD_S if self._stops_left else None
            return [self._frame(self._stop_flags)]
        if self._payload is None:
            self.due_s = None
            return []
        self.due_s = now_s + REPEAT_S
        return [self._frame(Flags.ARMED, self._payload)]

    def release(self) -> bytes:
        """Return the last datagram: robots that obey this sender stop, and accept other senders."""
        self._payload, self._stops_left, self.due_s = None, 0, None
        return self._frame(Flags.RELEASE)

    def query(self) -> bytes:
        """Return a datagram that requests a status and commands nothing."""
        return self._frame(Flags.QUERY)

    def forward(self, payload: bytes) -> bytes:
        """Return a query that also asks the robot to query another one (see `encode_forward`)."""
        return self._frame(Flags.QUERY | Flags.FORWARD, payload)

    def _end_motion(self, flags: Flags, now_s: float) -> list[bytes]:
        self._payload = None
        self._stops_left, self._stop_flags = _STOP_FRAMES, flags
        return self.repeat(now_s)

    def _frame(self, flags: Flags, payload: bytes = b"") -> bytes:
        if self.sequence == _LAST_SEQUENCE:
            self.sequence, self.epoch_us = 0, self.epoch_us + 1
        self.sequence += 1
        settings = self._settings
        if settings.to_groups:
            flags |= Flags.TO_GROUPS
        return CommandFrame(
            settings.target, self.epoch_us, self.sequence, flags, settings.ttl_ms, settings.kind, payload
        ).encode(settings.key)


class ReceiverSettings(Struct, frozen=True):
    """The robot's id and the mask of its groups. `kind` None accepts every type."""

    robot_id: int
    groups: int = 1
    kind: bytes | None = None
    key: bytes = NO_KEY


class CommandReceiver:
    """One robot. It obeys one sender until the sender releases it, or is silent for its time to live.

    The epoch of a sender is the time of its start. After a release or a silence, the robot also obeys senders
    with later epochs; it obeys a stop of a later epoch immediately. It never obeys an earlier epoch, so
    replayed frames have no effect.
    """

    def __init__(self, settings: ReceiverSettings) -> None:
        self._settings = settings
        # The epoch of the last sender that this robot obeyed, 0 before the first.
        self.last_epoch_us = 0
        self._sequence = 0
        # When to call `expire` next; None if no sender is active.
        self.deadline_s: float | None = None
        # The epoch and sequence number of the newest frame that was refused because of another sender:
        # replaying it has no effect.
        self._refused = (0, 0)
        self.is_moving = False
        # Why the last frame was refused, as text; empty if it was obeyed or ignored.
        self.last_refusal = ""
        # The last frame for this robot with a valid tag, and the reason if it was refused.
        self.last_frame: CommandFrame | None = None
        self.refusal = Refusal.NONE

    @property
    def holder_epoch_us(self) -> int | None:
        """The epoch of the sender that commands this robot now, None if there is none."""
        return None if self.deadline_s is None else self.last_epoch_us

    def receive(self, datagram: bytes, now_s: float) -> CommandFrame | None:
        """Return the frame to obey, None if it is refused (see `last_refusal`), repeated, or for others.

        A frame with the flag STOP or RELEASE, or without ARMED, ends all motion.
        """
        self.expire(now_s)
        self.last_frame, self.refusal, self.last_refusal = None, Refusal.NONE, ""
        try:
            frame = decode_frame(datagram, self._settings.key)
        except RemoteProtocolError as error:
            self.last_refusal = str(error)
            return None
        if not self._is_meant(frame):
            return None
        self.last_frame = frame
        if Flags.QUERY in frame.flags or self._is_repeated(frame):
            return None
        self.last_refusal = self._refusal_reason(frame)
        if self.last_refusal:
            return None
        self.last_epoch_us, self._sequence = frame.epoch_us, frame.sequence
        self.deadline_s = None if Flags.RELEASE in frame.flags else now_s + frame.ttl_ms / 1000
        self.is_moving = frame.flags & _MOTION == Flags.ARMED
        return frame

    def expire(self, now_s: float) -> bool:
        """End the sender's control if it was silent too long; return whether the robot must stop now."""
        if self.deadline_s is None or now_s < self.deadline_s:
            return False
        self.deadline_s = None
        was_moving, self.is_moving = self.is_moving, False
        return was_moving

    def _is_meant(self, frame: CommandFrame) -> bool:
        if Flags.TO_GROUPS in frame.flags:
            return bool(frame.target & self._settings.groups)
        return frame.target == self._settings.robot_id

    def _is_repeated(self, frame: CommandFrame) -> bool:
        newest = self._sequence if frame.epoch_us == self.last_epoch_us else 0
        if frame.epoch_us == self._refused[0]:
            newest = max(newest, self._refused[1])
        return frame.epoch_us >= self.last_epoch_us and frame.sequence <= newest

    def _refusal_reason(self, frame: CommandFrame) -> str:
        is_stop = Flags.STOP in frame.flags
        if frame.epoch_us < self.last_epoch_us:
            self.refusal = Refusal.OLDER
            return "the sender started before the last one: restart it (or this is a replayed command)"
        if frame.epoch_us > self.last_epoch_us and self.deadline_s is not None and not is_stop:
            self.refusal = Refusal.HELD
            self._refused = max(self._refused, (frame.epoch_us, frame.sequence))
            return "another sender commands this robot"
        # Frames that end motion have no payload, and so no type.
        if Flags.ARMED in frame.flags and not is_stop and self._settings.kind not in (None, frame.kind):
            self.refusal = Refusal.OTHER_TYPE
            return f"the command is of another type: its MD5 sum begins with {frame.kind.hex()}"
        return ""
