"""The node multicast_topic_bridge: the newest message of a topic, of any type, sent to a multicast group.

A bare datagram is only the message in ROS 1 serialization. A framed one can be checked by the
robot (`command_frame`), is repeated, and is followed by a stop at the end.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Mapping, Sequence

from msgspec import Struct, field
from msgspec.structs import replace

from rostether.errors import ConfigError
from rostether.graph.ports import Graph, Level, Report
from rostether.mechanisms.tasks import occurs_within
from rostether.msgdef.interface import ANY_MD5SUM, ANY_MESSAGE
from rostether.platform.command_channel import CommandChannel
from rostether.platform.command_frame import MAX_PAYLOAD_BYTES, type_kind
from rostether.platform.command_link import RELEASE_FRAMES, CommandSender, SenderSettings
from rostether.platform.datagram_sender import DatagramSender
from rostether.platform.multicast_socket import MAX_DATAGRAM_BYTES, GroupAddress
from rostether.platform.status_frame import Refusal

# At higher rates, pauses are too short for the event loop; 0 means no pauses.
_MAX_FREQUENCY_HZ = 10_000.0

# A datagram that could not be sent is tried again after this time at the earliest.
_RETRY_S = 0.01


class BridgeNodeSettings(Struct, frozen=True):
    """The parameters of the bridge; `frequency_hz` 0 sends every message immediately.

    `framed` is None for bare datagrams. A framed bridge whose topic is silent for `input_timeout_s` sends a
    stop; with 0, it repeats the last message until a new one arrives. `unicast` are addresses of robots that
    also get every frame by unicast.
    """

    topic: str = "multicast_topic"
    address: GroupAddress = field(default_factory=GroupAddress)
    frequency_hz: float = 1000.0
    framed: SenderSettings | None = None
    input_timeout_s: float = 0.5
    unicast: tuple[str, ...] = ()


async def send_topic(graph: Graph, settings: BridgeNodeSettings, report: Report) -> None:
    """Send the topic's messages until canceled. Raises ConfigError, InvalidNameError, GraphError."""
    if not 0 <= settings.frequency_hz <= _MAX_FREQUENCY_HZ:
        raise ConfigError(
            f"~frequency must be from 0 (no limit) to {_MAX_FREQUENCY_HZ:g} Hz, not {settings.frequency_hz:g}"
        )
    if not 0 <= settings.input_timeout_s < float("inf"):
        raise ConfigError(
            f"~input_timeout must be a time in seconds, or 0 for never, not {settings.input_timeout_s:g}"
        )
    bridge = (
        _FramedBridge(settings, settings.framed, report) if settings.framed else _Bridge(settings, report)
    )
    limit_bytes = MAX_PAYLOAD_BYTES if settings.framed else MAX_DATAGRAM_BYTES
    is_reported = False

    def receive(payloads: Sequence[bytes]) -> None:
        nonlocal is_reported
        newest = payloads[-1]
        if len(newest) <= limit_bytes:
            bridge.replace_newest(newest)
        elif not is_reported:
            is_reported = True
            report(
                Level.ERROR,
                f"a message of {len(newest)} bytes is not sent: a datagram contains at most {limit_bytes}; "
                "publish smaller messages",
            )

    subscriber = await graph.subscribe(settings.topic, ANY_MESSAGE, receive, on_connection=bridge.set_type)
    report(Level.INFO, f"sending {subscriber.topic} to {settings.address}")
    try:
        await bridge.run()
    finally:
        bridge.end()
        await subscriber.close()


class _Bridge:
    """Bare datagrams: sends the newest message once, at most `frequency_hz` times a second."""

    def __init__(self, settings: BridgeNodeSettings, report: Report) -> None:
        self._sender = DatagramSender(settings.address.checked(), report)
        self._period_s = 1 / settings.frequency_hz if settings.frequency_hz else 0.0
        self._newest = b""
        self._has_message = asyncio.Event()

    def replace_newest(self, payload: bytes) -> None:
        """Replace the waiting message."""
        self._newest = payload
        self._has_message.set()

    def set_type(self, header: Mapping[str, str]) -> None:
        """Ignore the type: bare datagrams do not contain it."""

    async def run(self) -> None:
        next_s = 0.0
        while True:
            await self._has_message.wait()
            now_s = time.monotonic()
            if now_s < next_s:
                await asyncio.sleep(next_s - now_s)
                now_s = time.monotonic()
            # While messages arrive, due times keep a fixed grid: a late timer does not lower the frequency.
            next_s = max(next_s, now_s - self._period_s) + self._period_s
            if self._sender.send(self._newest):
                self._has_message.clear()
            else:
                await asyncio.sleep(_RETRY_S)

    def end(self) -> None:
        """Close the sockets; bare datagrams need no stop."""
        self._sender.close()


class _FramedBridge:
    """Framed datagrams: repeats the newest message until the topic is silent."""

    def __init__(self, settings: BridgeNodeSettings, framed: SenderSettings, report: Report) -> None:
        self._settings = framed
        self._timeout_s = settings.input_timeout_s or float("inf")
        self._period_s = 1 / settings.frequency_hz if settings.frequency_hz else 0.0
        self._channel = CommandChannel(settings.address, report, key=framed.key, unicast=settings.unicast)
        self._commands: CommandSender | None = None
        self._newest: bytes | None = None
        self._silent_at_s: float | None = None
        self._has_message = asyncio.Event()

    def replace_newest(self, payload: bytes) -> None:
        """Replace the waiting message."""
        self._newest = payload
        self._has_message.set()

    def set_type(self, header: Mapping[str, str]) -> None:
        """Set the type of the topic; a new type starts a new sender."""
        md5sum = header.get("md5sum", ANY_MD5SUM)
        if md5sum == ANY_MD5SUM:
            return
        kind = type_kind(md5sum)
        if self._commands is None or kind != self._settings.kind:
            self._release()
            self._settings = replace(self._settings, kind=kind)
            self._commands = self._channel.start_sender(self._settings)
            self._has_message.set()

    async def run(self) -> None:
        next_message_s = 0.0
        while True:
            await self._wait(next_message_s)
            now_s = time.monotonic()
            if self._commands is None:
                continue
            if self._newest is not None and now_s >= next_message_s:
                datagrams = self._commands.command(self._newest, now_s)
                self._newest = None
                next_message_s = now_s + self._period_s
                self._silent_at_s = now_s + self._timeout_s
            elif self._silent_at_s is not None and now_s >= self._silent_at_s:
                datagrams, self._silent_at_s = self._commands.halt(now_s), None
                if Refusal.OLDER in self._channel.refused.values():
                    # Another program has stopped the robots; the next message may command them again.
                    self._commands = self._channel.start_sender(self._settings)
            elif self._commands.due_s is not None and now_s >= self._commands.due_s:
                datagrams = self._commands.repeat(now_s)
            else:
                continue
            for datagram in datagrams:
                self._channel.send(datagram)

    async def _wait(self, next_message_s: float) -> None:
        """Wait until a message may be sent, or a repetition is due."""
        is_waiting = self._newest is not None and self._commands is not None
        times = [self._silent_at_s, self._commands.due_s if self._commands else None]
        times.append(next_message_s if is_waiting else None)
        next_s = min((each for each in times if each is not None), default=float("inf"))
        self._has_message.clear()
        wait_s = None if next_s == float("inf") else max(0.0, next_s - time.monotonic())
        await occurs_within(self._has_message, wait_s)

    def end(self) -> None:
        """Stop and release the robots, and close the sockets."""
        self._release()
        self._channel.close()

    def _release(self) -> None:
        if self._commands is not None:
            for _ in range(RELEASE_FRAMES):
                self._channel.send(self._commands.release())
