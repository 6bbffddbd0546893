"""Watches one connection: handles every event except messages, and reports problems of the line.

It depends only on the events and counters of the link, not on the graph or the transport.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rostether.bridge.findings.announcement_findings import AnnouncementFindings
from rostether.bridge.findings.damage import Damage
from rostether.bridge.findings.finding import Code, Finding, error, warning
from rostether.bridge.findings.loop_speed import LoopSpeed
from rostether.bridge.findings.medium import Medium
from rostether.bridge.findings.noise import Noise, absence, show
from rostether.bridge.findings.oversize import Oversizes
from rostether.bridge.findings.resets import MIN_STARTS, UNSETTLED_S, Resets, reset_loop
from rostether.bridge.findings.unannounced import UnannouncedMessages
from rostether.rosserial.events import (
    AnnouncementRefused,
    DeviceReset,
    DeviceSilent,
    FrameDiscarded,
    HostEvent,
    LogReceived,
    NegotiationSettled,
    ParameterRequested,
    ProtocolDetected,
    ServiceAnnounced,
    TimeRequested,
    TopicAnnounced,
    TopicRole,
    UnknownTopicId,
)
from rostether.rosserial.frame import MAX_PAYLOAD_BYTES
from rostether.rosserial.link_statistics import LinkStatistics

# By then a board that was reset when the port was opened has left its bootloader.
NO_ANSWER_S = 5.0

# The checks are a second apart. A longer time means that this process was paused, and read requests late.
PAUSED_S = 3.0

# The log line of the established library for a message that does not fit in its output buffer.
TOO_LARGE = "larger than buffer"

# What to check if a board is silent, in addition to its power; on a serial line, the cable.
_CONNECTIONS = {Medium.TCP: "network", Medium.UDP: "network", Medium.RADIO: "radio"}

_SIGNS_OF_LIFE = (
    TimeRequested,
    TopicAnnounced,
    ServiceAnnounced,
    LogReceived,
    ParameterRequested,
    ProtocolDetected,
)


class LineWatch:
    """One connection of one board, with the `baud` rate of a serial line, and the board's `resets` so far."""

    def __init__(
        self,
        baud: int | None,
        resets: Resets,
        statistics: LinkStatistics,
        now_s: float,
        *,
        medium: Medium = Medium.SERIAL,
    ) -> None:
        self.noise = Noise()
        self.loop_speed = LoopSpeed(may_lose=medium.may_lose)
        self.oversizes = Oversizes()

        # When the board last logged that a message did not fit in its buffer.
        self.too_large_s = float("-inf")
        self._baud = baud
        self._resets = resets
        self._statistics = statistics
        self._opened_s = self._found_s = now_s
        self._medium = medium
        self._damage = Damage(medium)
        self._announcements = AnnouncementFindings()
        self._version: int | None = None
        self._alive_s: float | None = None
        self._silence_s: float | None = None
        self._settled_s: float | None = None
        self._settled_starts = 0
        self._unannounced = UnannouncedMessages()
        self._is_listener = False
        self._handlers: dict[type[Any], Callable[[Any, float], None]] = {
            AnnouncementRefused: lambda event, _: self._announcements.refused(event),
            DeviceReset: self._device_reset,
            DeviceSilent: self._device_silent,
            FrameDiscarded: self._discarded,
            LogReceived: self._log_received,
            NegotiationSettled: self._settled,
            ProtocolDetected: self._protocol_detected,
            ServiceAnnounced: self._service_announced,
            TimeRequested: lambda _, now_s: self.loop_speed.request(now_s, statistics.topic_requests),
            TopicAnnounced: self._topic_announced,
            UnknownTopicId: self._unannounced.record,
        }

    @property
    def was_alive(self) -> bool:
        """Whether a frame has arrived that only a rosserial board sends."""
        return self._alive_s is not None

    def handle_event(self, event: HostEvent, now_s: float) -> None:
        """Note a sign of life, and count what the event shows about the line."""
        if isinstance(event, _SIGNS_OF_LIFE):
            self._silence_s = None
            self.noise.note_board_frame()
        handle = self._handlers.get(type(event))
        if handle is not None:
            handle(event, now_s)

    def find(self, now_s: float) -> list[Finding]:
        """Return the current findings, the worst first. Called about once a second."""
        if now_s - self._found_s > PAUSED_S:
            self.loop_speed.forget()
        self._found_s = now_s
        damage = None
        if self.was_alive:
            damage = self._damage.find(self._statistics.frames_received, now_s, self._resets.count(now_s))
        resets = self._find_resets(now_s, damage)
        # A board that restarts also restarts its period, which makes its request late.
        is_listener = self._is_listener and self._medium is Medium.SERIAL
        slow = None if resets else self.loop_speed.find(is_listener=is_listener)
        found = [
            self._find_absence(now_s),
            resets,
            *self._announcements.find(),
            self._find_version(),
            damage,
            self._find_text(),
            self._unannounced.find(now_s),
            slow,
        ]
        return [each for each in found if each is not None]

    def _device_reset(self, _event: DeviceReset, now_s: float) -> None:
        self._resets.record(now_s)
        self.loop_speed.forget()

    def _device_silent(self, event: DeviceSilent, _now_s: float) -> None:
        self._silence_s = event.silence_s
        self._damage.forget_unconfirmed()

    def _log_received(self, event: LogReceived, now_s: float) -> None:
        if TOO_LARGE in event.text:
            self.too_large_s = now_s

    def _settled(self, _event: NegotiationSettled, now_s: float) -> None:
        self._settled_s = now_s
        self._settled_starts = self._statistics.time_requests

    def _protocol_detected(self, event: ProtocolDetected, now_s: float) -> None:
        self._version = event.version
        self._alive_s = now_s

    def _service_announced(self, event: ServiceAnnounced, _now_s: float) -> None:
        self._is_listener = True
        for info in (event.request, event.response):
            self._unannounced.announced(info.topic_id)

    def _topic_announced(self, event: TopicAnnounced, _now_s: float) -> None:
        # Only rostether's client library sends without a buffer.
        self.loop_speed.has_own_library |= event.info.buffer_size >= MAX_PAYLOAD_BYTES
        self._is_listener |= event.role is TopicRole.SUBSCRIBER
        self._unannounced.announced(event.info.topic_id)

    def _discarded(self, event: FrameDiscarded, now_s: float) -> None:
        if self.oversizes.handle_discarded(event, self._version, now_s):
            return
        # The bytes before the first frame are the rest of a burst from before the port was opened.
        is_alive = self._alive_s is not None and now_s > self._alive_s and self._silence_s is None
        # A sketch cannot print between datagrams: text is the rest of a message.
        loses_datagrams = self._medium is Medium.UDP
        was_text = self.noise.handle_discarded(event, now_s, is_alive=is_alive and not loses_datagrams)
        self._announcements.discarded(event)
        may_be_damage = self.was_alive and self._silence_s is None and (loses_datagrams or not was_text)
        if may_be_damage and self._damage.count_discarded(event, now_s, self._statistics.frames_received):
            # The damaged frame may be a time request.
            self.loop_speed.forget()

    @property
    def is_silent(self) -> bool:
        """Whether a board that has answered before is silent for too long."""
        return self._silence_s is not None

    def _find_absence(self, now_s: float) -> Finding | None:
        if self._silence_s is None:
            if self.was_alive or now_s - self._opened_s < NO_ANSWER_S:
                return None
            return absence(self.noise, self._baud, now_s - self._opened_s)
        if self.noise.byte_count:
            return absence(self.noise, self._baud, self._silence_s)
        return error(
            Code.BOARD_SILENT,
            f"the board has been silent for {self._silence_s:.0f} s; requesting its topics until it answers",
            f"check its power and its {_CONNECTIONS.get(self._medium, 'cable')}, and that loop() still runs "
            "and calls nh.spinOnce()",
        )

    def _find_resets(self, now_s: float, damage: Finding | None) -> Finding | None:
        crash_line = self.noise.crash_line()
        found = self._resets.find(now_s, crash_line)
        if found is not None or damage is not None or self._alive_s is None:
            return found
        began_s = self._alive_s if self._settled_s is None else self._settled_s
        starts = self._statistics.time_requests - self._settled_starts
        if self._settled_s is None and now_s - began_s >= UNSETTLED_S and starts >= MIN_STARTS:
            seen = (
                f"the board started to announce its topics {starts} times in {now_s - began_s:.0f} s but "
                "never finished; it probably resets in a loop"
            )
            return reset_loop(seen, crash_line)
        return None

    def _find_version(self) -> Finding | None:
        if self._version == 1:
            return warning(
                Code.PROTOCOL_VERSION,
                "the board speaks protocol version 1 (ROS Groovy or earlier), which detects damage less well",
                "it works; generate the client library again with rostether firmware lib and upload the "
                "sketch",
            )
        return None

    def _find_text(self) -> Finding | None:
        if not self.noise.text_count or not self.was_alive:
            return None
        return warning(
            Code.TEXT_BETWEEN_FRAMES,
            f"there is text between the frames ({show(self.noise.text)}): the sketch prints on the port that "
            "rosserial uses",
            "replace Serial.print with nh.loginfo, or print on another port",
        )
