"""Decides which sender gets a robot's status, and when. Without sockets or clocks."""

from __future__ import annotations

from collections.abc import Callable

from msgspec import Struct

from rostether.platform.command_frame import CommandFrame, Flags
from rostether.platform.command_link import CommandReceiver
from rostether.platform.status_frame import HostState, RobotStatus

# The interval between the reports to a sender that drives the robot: often enough for a list of robots.
STATUS_PERIOD_S = 1.0

# The interval between answers to queries and stops. It is short because the sender waits, and an answer may
# be lost.
_QUICK_PERIOD_S = 0.25

# Enough for the sender that the robot obeys, a second one, and some programs that list the fleet.
_MAX_SENDERS = 8


class _Sender(Struct):
    """The frames of one epoch; `address` is the source of its newest frame, as text."""

    address: str
    sequence: int
    received_count: int = 1
    lost_count: int = 0
    next_status_s: float = float("-inf")


class StatusReporter:
    """Counts the frames of each sender, and answers it while its frames arrive: once a second for commands.

    Only newer frames with a valid tag count, so a replayed frame from another address gets no answer.
    """

    def __init__(self, robot_id: int, key: bytes) -> None:
        self._robot_id = robot_id
        self._key = key
        self._senders: dict[int, _Sender] = {}

    def answer(
        self,
        receiver: CommandReceiver,
        address: str,
        now_s: float,
        read_signal_dbm: Callable[[], int | None] = lambda: None,
        read_host: Callable[[], HostState | None] = lambda: None,
    ) -> bytes | None:
        """Return the status for the sender of the last frame of `receiver`, if it is due.

        `address` is the frame's source.
        """
        frame = receiver.last_frame
        if frame is None or (sender := self._count(frame, address)) is None or now_s < sender.next_status_s:
            return None
        is_driving = Flags.ARMED in frame.flags
        sender.next_status_s = now_s + (STATUS_PERIOD_S if is_driving else _QUICK_PERIOD_S)
        holder = self._senders.get(receiver.holder_epoch_us or 0)
        return RobotStatus(
            self._robot_id,
            frame.epoch_us,
            frame.sequence,
            sender.received_count,
            sender.lost_count,
            receiver.is_moving,
            receiver.refusal,
            read_signal_dbm(),
            holder.address if holder else "",
            read_host(),
            receiver.last_epoch_us,
        ).encode(self._key)

    def _count(self, frame: CommandFrame, address: str) -> _Sender | None:
        sender = self._senders.pop(frame.epoch_us, None)
        if sender is None:
            sender = _Sender(address, frame.sequence)
            while len(self._senders) >= _MAX_SENDERS:
                del self._senders[next(iter(self._senders))]
        elif frame.sequence <= sender.sequence:
            self._senders[frame.epoch_us] = sender
            return None
        else:
            sender.lost_count += frame.sequence - sender.sequence - 1
            sender.received_count += 1
            sender.address, sender.sequence = address, frame.sequence
        self._senders[frame.epoch_us] = sender
        return sender
