"""Commands to a fleet without a ROS graph: query, stop and drive robots by id or group."""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Callable

from msgspec import Struct, field

from rostether.errors import TransportError
from rostether.graph.ports import Level, Report
from rostether.platform.command_channel import CommandChannel, refusal_text
from rostether.platform.command_link import RELEASE_FRAMES, REPEAT_S, SenderSettings
from rostether.platform.multicast_socket import GroupAddress
from rostether.platform.robot_table import Robot
from rostether.platform.status_frame import Refusal

FLEET_GROUP = "239.255.82.83"
FLEET_PORT = 11412

# Every robot answers ten times within this time, so a few lost answers do not matter.
QUERY_S = 2.5
# A robot in range confirms a stop within this time.
_CONFIRM_S = 0.3
_STOP_ROUNDS = 3
# Without an answer after this time, the user is informed.
_ANSWER_S = 1.5
# After a longer pause, the robots have stood still for a while, and must not start again unexpectedly.
_MAX_PAUSE_S = 2.0


class FleetSettings(Struct, frozen=True):
    """The target of commands (`sender`), their address, and the hosts that also get unicast."""

    sender: SenderSettings = field(default_factory=SenderSettings)
    address: GroupAddress = field(default_factory=lambda: GroupAddress(FLEET_GROUP, FLEET_PORT))
    unicast: tuple[str, ...] = ()


class FleetSender:
    """One sender, from its first frame to its release. Raises ConfigError for a wrong address."""

    def __init__(self, settings: FleetSettings, report: Report) -> None:
        self._settings = settings
        self._report = report
        self._channel = CommandChannel(
            settings.address,
            report,
            key=settings.sender.key,
            unicast=settings.unicast,
            reports_refusals=settings.sender.to_groups,
        )
        self._begin()
        self._has_commanded = False

    @property
    def robots(self) -> list[Robot]:
        """The robots that have answered, sorted by id and host."""
        return [robot for _, robot in sorted(self._channel.table.robots.items())]

    async def query(self, duration_s: float = QUERY_S, period_s: float = REPEAT_S) -> None:
        """Request statuses every `period_s` for `duration_s`."""
        end_s = time.monotonic() + duration_s
        while time.monotonic() < end_s:
            self._send([self._commands.query()])
            await asyncio.sleep(period_s)

    async def drive(self, payload: bytes, duration_s: float = float("inf")) -> None:
        """Send a command for some time, then stop.

        Raises TransportError if a single target robot refuses it, or after a pause of this process.
        """
        self._has_commanded = True
        await self._start_later_epoch()
        began_s = time.monotonic()
        end_s, is_reported = began_s + duration_s, False
        sent_s = _now_with_suspend_s()
        try:
            self._send(self._commands.command(payload, began_s))
            while (now_s := time.monotonic()) < end_s:
                await asyncio.sleep(max(0.0, min(self._commands.due_s or now_s, end_s) - now_s))
                paused_s, sent_s = _now_with_suspend_s() - sent_s, _now_with_suspend_s()
                if paused_s > _MAX_PAUSE_S:
                    raise TransportError(
                        f"the robots stopped, because this program was paused for {paused_s:.0f} s; "
                        "start it again to continue"
                    )
                self._send(self._commands.repeat(time.monotonic()))
                self._check_refusals()
                if not is_reported and not self.robots and now_s - began_s > _ANSWER_S:
                    is_reported = True
                    self._report(Level.WARN, silence_text(self._settings))
        finally:
            # Not `stop`: that would stop robots that another sender commands, and that refused this one.
            await self._repeat(self._commands.halt(time.monotonic()))
        if not is_reported and not self.robots:
            self._report(Level.WARN, silence_text(self._settings))

    async def stop(self) -> list[Robot]:
        """Stop, and return the robots that answer; `has_stopped` returns whether one confirms the stop.

        It sends more rounds until the target robot confirms, or until no new robot of a group answers.
        """
        self._has_commanded = True
        for _ in range(_STOP_ROUNDS):
            count = len(self.robots)
            await self._repeat_stop()
            await self._wait_for_answers()
            is_complete = not self._settings.sender.to_groups or len(self.robots) == count
            if self.robots and is_complete and all(map(has_stopped, self.robots)):
                break
        return self.robots

    def close(self) -> None:
        """Release the robots, so that other senders may command them, and close the sockets."""
        # If only queries were sent, robots would obey the release as that of a later sender, and then refuse
        # earlier senders.
        if self._has_commanded:
            self._send([self._commands.release() for _ in range(RELEASE_FRAMES)])
        self._channel.close()

    def _begin(self) -> None:
        """Start an epoch, later than that of every known sender."""
        self._commands = self._channel.start_sender(self._settings.sender)
        # The known refusals are those of the earlier epoch.
        self._channel.table.robots.clear()

    async def _start_later_epoch(self) -> None:
        """Before the first command, start a later epoch if the clock of an earlier sender was ahead.

        A stop that another sender sends after that still ends the drive.
        """
        await self._repeat(self._commands.halt(time.monotonic()), self._has_single_answer)
        if self._channel.is_overtaken:
            self._begin()

    async def _repeat_stop(self) -> None:
        """Send a stop; begin a later epoch if a robot refuses it because an earlier clock was ahead."""
        for _ in range(_STOP_ROUNDS):
            await self._repeat(self._commands.stop(time.monotonic()), lambda: self._channel.is_overtaken)
            if not self._channel.is_overtaken:
                return
            self._begin()

    async def _repeat(self, datagrams: list[bytes], is_enough: Callable[[], bool] = lambda: False) -> None:
        """Send datagrams and their repetitions, until all are sent or `is_enough()`."""
        self._send(datagrams)
        while self._commands.due_s is not None:
            await asyncio.sleep(max(0.0, self._commands.due_s - time.monotonic()))
            if is_enough():
                return
            self._send(self._commands.repeat(time.monotonic()))

    def _has_single_answer(self) -> bool:
        return bool(self.robots) and not self._settings.sender.to_groups

    async def _wait_for_answers(self) -> None:
        end_s = time.monotonic() + _CONFIRM_S
        while time.monotonic() < end_s:
            await asyncio.sleep(REPEAT_S)
            if self._has_single_answer():
                return

    def _check_refusals(self) -> None:
        """Raise TransportError if the only target refuses; the channel reports robots of a group."""
        if self._settings.sender.to_groups:
            return
        for robot in self.robots:
            if robot.status.refusal is not Refusal.NONE:
                raise TransportError(refusal_text(robot.status))

    def _send(self, datagrams: list[bytes]) -> None:
        for datagram in datagrams:
            self._channel.send(datagram)


def _now_with_suspend_s() -> float:
    """Return the time of a clock that continues while the machine sleeps, if the system has one."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) if sys.platform == "linux" else time.monotonic()


def has_stopped(robot: Robot) -> bool:
    """Return whether a robot has confirmed a stop; its answer may also be a refusal."""
    return robot.status.refusal is Refusal.NONE and not robot.status.is_moving


def silence_text(settings: FleetSettings) -> str:
    """Return the advice if no robot answers."""
    sender = settings.sender
    who = "no robot" if sender.to_groups else f"robot {sender.target} does not"
    return (
        f"{who} answer{'s' if sender.to_groups else ''} at {settings.address}; check the key, the "
        "interface (--interface), and whether the access point passes multicast (--unicast ADDRESS)"
    )
