"""The node multicast_topic_receiver: messages from a multicast group published on a topic."""

from __future__ import annotations

import asyncio
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from rostether.errors import ConfigError
from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph, TypedPublisher
from rostether.mechanisms.repeat_limiter import RepeatLimiter
from rostether.platform.command_link import CommandReceiver, ReceiverSettings
from rostether.platform.multicast_socket import GroupAddress, join_group, open_receiver
from rostether.serde.layout import Layout
from rostether.transports.allow_list import AllowList, check_networks
from rostether.transports.own_names import own_addresses

# A switch that forgets a group (no querier) is informed again when nothing comes, and once a minute.
SILENCE_S = 2.0
REJOIN_S = 60.0
# The number of datagrams that are read before other tasks run.
_BURST = 100
_MAX_BYTES = 65_536


@dataclass(frozen=True, slots=True)
class ReceiverNodeSettings:
    """The parameters of the receiver.

    `sources` are the networks that may send, besides this machine; with a key, none means all. `framed` is
    None for bare datagrams.
    """

    type_name: str
    topic: str = "multicast_topic"
    address: GroupAddress = field(default_factory=GroupAddress)
    sources: tuple[str, ...] = ()
    framed: ReceiverSettings | None = None
    has_key: bool = False


async def receive_topic(
    graph: TypedGraph, settings: ReceiverNodeSettings, report: Callable[[Level, str], None]
) -> None:
    """Publish what arrives until cancelled. Raises ConfigError, UnknownTypeError, GraphError."""
    address = settings.address.checked()
    sources = check_networks(settings.sources, "~sources")
    publisher = await graph.publisher(settings.topic, settings.type_name)
    if not sources and not settings.has_key:
        # It may ask a name server.
        sources = tuple(str(each) for each in await asyncio.to_thread(own_addresses))
    try:
        sock = open_receiver(address)
    except OSError as error:
        raise ConfigError(f"cannot receive at {address}: {error.strerror or error}") from None
    layout = graph.store.layout(settings.type_name)
    receiver = _Receiver(sock, publisher, layout, AllowList(sources), settings, report)
    loop = asyncio.get_running_loop()
    loop.add_reader(sock, receiver.read)
    report(Level.INFO, f"receiving {settings.type_name} from {address} as {publisher.topic}")
    try:
        await receiver.keep_joined()
    finally:
        loop.remove_reader(sock)
        receiver.close()
        sock.close()


class _Receiver:
    """From opening the socket to its end."""

    def __init__(
        self,
        sock: socket.socket,
        publisher: TypedPublisher,
        layout: Layout,
        sources: AllowList,
        settings: ReceiverNodeSettings,
        report: Callable[[Level, str], None],
    ) -> None:
        self._sock = sock
        self._publisher = publisher
        self._layout = layout
        self._sources = sources
        self._address = settings.address
        self._commands = None if settings.framed is None else CommandReceiver(settings.framed)
        self._report = report
        self._limiter = RepeatLimiter()
        self._last_s = time.monotonic()
        self._watchdog: asyncio.TimerHandle | None = None

    async def keep_joined(self) -> None:
        """Join, and join again in time, until cancelled."""
        if not self._address.is_multicast:
            await asyncio.Event().wait()
        failed = False
        while True:
            joined_s = time.monotonic()
            failures = [self._join(each) for each in self._address.interfaces or ("",)]
            if any(failures) and not failed:
                self._report(Level.ERROR, next(filter(None, failures)))
            failed = any(failures)
            while True:
                await asyncio.sleep(SILENCE_S)
                now_s = time.monotonic()
                if failed or now_s - self._last_s >= SILENCE_S or now_s - joined_s >= REJOIN_S:
                    break

    def read(self) -> None:
        """Read what has come."""
        for _ in range(_BURST):
            try:
                datagram, source = self._sock.recvfrom(_MAX_BYTES)
            except OSError:
                return
            self._last_s = time.monotonic()
            host = str(source[0])
            if not self._sources.allows(host):
                self._refuse(f"a datagram from {host}: allow it with _sources:={host}")
            elif self._commands is not None:
                self._obey(self._commands, datagram, host)
            else:
                self._publish(datagram, host)

    def close(self) -> None:
        """End the watchdog, after a last stop for a robot that moves."""
        if self._watchdog is not None:
            self._watchdog.cancel()
        if self._commands is not None and self._commands.is_moving:
            self._publisher.publish()

    def _join(self, interface: str) -> str:
        try:
            join_group(self._sock, self._address, interface)
        except OSError as error:
            by = f" on {interface}" if interface else ""
            return (
                f"cannot join {self._address.group}{by}: {error.strerror or error}; trying again. "
                "~interface chooses the network interface"
            )
        return ""

    def _obey(self, commands: CommandReceiver, datagram: bytes, host: str) -> None:
        was_moving, refused_count = commands.is_moving, commands.refused_count
        frame = commands.receive(datagram, self._last_s)
        if commands.refused_count > refused_count and "not newer" not in commands.last_refusal:
            self._refuse(f"a command from {host}: {commands.last_refusal}")
        if frame is None:
            return
        if commands.is_moving:
            self._publish(frame.payload, host)
        elif was_moving:
            self._publisher.publish()
        self._watch(commands)

    def _watch(self, commands: CommandReceiver) -> None:
        if self._watchdog is not None:
            self._watchdog.cancel()
            self._watchdog = None
        if commands.deadline_s is not None:
            delay_s = commands.deadline_s - time.monotonic()
            self._watchdog = asyncio.get_running_loop().call_later(delay_s, self._expire, commands)

    def _expire(self, commands: CommandReceiver) -> None:
        self._watchdog = None
        if commands.expired(time.monotonic()):
            self._report(Level.WARN, f"no command for its time to live; {self._publisher.topic} is stopped")
            self._publisher.publish()
        else:
            self._watch(commands)

    def _publish(self, payload: bytes, host: str) -> None:
        if self._layout.accepts(payload):
            self._publisher.raw.publish_raw([payload])
        else:
            self._refuse(f"a datagram from {host}: {self._layout.explain(payload)}")

    def _refuse(self, reason: str) -> None:
        suppressed = self._limiter.admit(reason, self._last_s)
        if suppressed is not None:
            also = f" ({suppressed} more since the last report)" if suppressed else ""
            self._report(Level.WARN, f"ignored {reason}{also}")
