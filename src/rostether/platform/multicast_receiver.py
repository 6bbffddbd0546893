"""The node multicast_topic_receiver: publishes the messages from a multicast group on a topic."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import time
from collections.abc import Callable
from functools import partial

from msgspec import Struct, field
from msgspec.structs import replace

from rostether.errors import ConfigError, RemoteProtocolError
from rostether.graph.ports import Level, Report
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.mechanisms.rate_limits import LineBudget, RepeatLimiter
from rostether.platform.command_frame import Flags, decode_forward
from rostether.platform.command_link import CommandReceiver, ReceiverSettings
from rostether.platform.host_state import read_host, read_signal_dbm
from rostether.platform.multicast_socket import (
    GroupAddress,
    join_group,
    open_receiver,
    open_sender,
    open_unicast,
)
from rostether.platform.robot_table import SocketAddress
from rostether.platform.status_frame import MAGIC as STATUS_MAGIC
from rostether.platform.status_frame import HostState
from rostether.platform.status_reporter import StatusReporter
from rostether.serde.layout import Layout
from rostether.transports.allow_list import ALWAYS_ALLOWED, AllowList, check_networks
from rostether.transports.own_names import is_own_address

# Joins are repeated if no datagram arrives, and once a minute: without a querier, switches forget a group.
SILENCE_S = 2.0
_REJOIN_S = 60.0
# How long datagrams are handled before other tasks run: checking the tag of the longest takes 0.3 ms.
_TURN_S = 0.005
# No datagram is longer.
_MAX_BYTES = 65_536
# The socket for statuses has no group; the address only selects the family.
_NO_GROUP = {socket.AF_INET: "127.0.0.1", socket.AF_INET6: "::1"}


class ReceiverNodeSettings(Struct, frozen=True):
    """The parameters of the receiver.

    `sources` are the networks that may send, besides this machine; with a key, an empty list allows all.
    `framed` is None for bare datagrams.
    """

    type_name: str
    topic: str = "multicast_topic"
    address: GroupAddress = field(default_factory=GroupAddress)
    sources: tuple[str, ...] = ()
    framed: ReceiverSettings | None = None
    has_key: bool = False


async def receive_topic(
    graph: TypedGraph,
    settings: ReceiverNodeSettings,
    report: Report,
    read_host: Callable[[], HostState] = read_host,
) -> None:
    """Publish received messages until canceled. Raises ConfigError, DefinitionError, GraphError."""
    address = settings.address.checked()
    sources = check_networks(settings.sources, "~sources")
    publisher = await graph.publisher(settings.topic, settings.type_name)
    if not sources and not settings.has_key:
        sources = ALWAYS_ALLOWED
    try:
        sock = open_receiver(address)
    except OSError as error:
        # A group of one link (ff02::1) needs an interface.
        step = (
            "choose the network interface with ~interface"
            if address.is_multicast
            else "choose an address of this machine and a free port"
        )
        raise ConfigError(f"cannot receive at {address}: {error.strerror or error}; {step}") from None
    layout = graph.store.layout(settings.type_name)
    receiver = _Receiver(sock, publisher, layout, AllowList(sources), settings, report, read_host)
    report(Level.INFO, f"receiving {settings.type_name} from {address} as {publisher.topic}")
    try:
        await receiver.keep_joined()
    finally:
        receiver.close()


class _Receiver:
    """One run of the receiver, from opening the socket to closing it."""

    def __init__(
        self,
        sock: socket.socket,
        publisher: TypedPublisher[...],
        layout: Layout,
        sources: AllowList,
        settings: ReceiverNodeSettings,
        report: Report,
        read_host: Callable[[], HostState],
    ) -> None:
        self._read_host = read_host
        self._sock = sock
        self._publisher = publisher
        self._layout = layout
        self._sources = sources
        self._address = settings.address
        self._commands: CommandReceiver | None = None
        self._report = report
        self._limiter = RepeatLimiter()
        self._budget = LineBudget()
        self._last_s = time.monotonic()
        self._watchdog: asyncio.TimerHandle | None = None
        self._sockets = [sock]
        if settings.framed is not None:
            self._commands = CommandReceiver(settings.framed)
            self._key = settings.framed.key if settings.has_key else None
            self._reporter = StatusReporter(settings.framed.robot_id, settings.framed.key)
            # Statuses have their own port, so that a sender's unicast reaches only this robot.
            self._own = open_sender(replace(self._address, group=_NO_GROUP[self._address.family]), "")
            self._sockets.append(self._own)
            if (unicast := open_unicast(self._address)) is not None:
                self._sockets.append(unicast)
        for each in self._sockets:
            asyncio.get_running_loop().add_reader(each, self._read, each)

    async def keep_joined(self) -> None:
        """Join the group, and join again when necessary, until canceled."""
        if not self._address.is_multicast:
            await asyncio.Event().wait()
        has_failed = False
        while True:
            joined_s = time.monotonic()
            failures = [self._join(each) for each in self._address.interfaces or ("",)]
            if any(failures) and not has_failed:
                self._report(Level.ERROR, next(filter(None, failures)))
            has_failed = any(failures)
            while True:
                await asyncio.sleep(SILENCE_S)
                now_s = time.monotonic()
                if has_failed or now_s - self._last_s >= SILENCE_S or now_s - joined_s >= _REJOIN_S:
                    break

    def _read(self, sock: socket.socket) -> None:
        end_s = time.monotonic() + _TURN_S
        while (now_s := time.monotonic()) < end_s:
            try:
                datagram, source = sock.recvfrom(_MAX_BYTES)
            except OSError:
                return
            self._last_s = now_s
            host = str(source[0])
            if not self._sources.allows(host) and not is_own_address(host, *source[3:]):
                self._refuse(f"a datagram from {host}: allow it with _sources:={host}")
            elif self._commands is None:
                self._publish(datagram, host)
            elif not datagram.startswith(STATUS_MAGIC):
                self._obey(self._commands, datagram, source)

    def close(self) -> None:
        """Close the sockets and end the watchdog, after a last stop for a robot that moves."""
        for each in self._sockets:
            asyncio.get_running_loop().remove_reader(each)
            each.close()
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

    def _obey(self, commands: CommandReceiver, datagram: bytes, source: SocketAddress) -> None:
        host = source[0]
        # A busy loop may read a query before it runs the watchdog.
        self._stop_if_expired(commands, self._last_s)
        was_moving = commands.is_moving
        frame = commands.receive(datagram, self._last_s)
        if commands.last_refusal:
            self._refuse(f"a command from {host}: {commands.last_refusal}")
        self._answer(commands, source)
        if commands.last_frame is not None and Flags.FORWARD in commands.last_frame.flags:
            self._forward(commands.last_frame.payload, host)
        if frame is None:
            return
        if commands.is_moving:
            self._publish(frame.payload, host)
        elif was_moving:
            self._publisher.publish()
        self._watch(commands)

    def _answer(self, commands: CommandReceiver, source: SocketAddress) -> None:
        text = str(replace(self._address, group=source[0], port=source[1]))
        status = self._reporter.answer(
            commands, text, self._last_s, partial(read_signal_dbm, self._address.interfaces), self._read_host
        )
        if status is not None:
            with contextlib.suppress(OSError):
                self._own.sendto(status, source)

    def _forward(self, payload: bytes, host: str) -> None:
        """Send a query to another robot for a sender that has the key; its answer is ignored."""
        if self._key is None:
            return
        try:
            address, port, query = decode_forward(payload, self._key)
        except RemoteProtocolError as error:
            self._refuse(f"a query from {host}: {error}")
            return
        # The other robot may have an address of another kind, or one that this machine has no route to.
        with contextlib.suppress(OSError):
            self._own.sendto(query, (address, port))

    def _watch(self, commands: CommandReceiver) -> None:
        if self._watchdog is not None:
            self._watchdog.cancel()
            self._watchdog = None
        if commands.deadline_s is not None:
            delay_s = commands.deadline_s - time.monotonic()
            self._watchdog = asyncio.get_running_loop().call_later(delay_s, self._expire, commands)

    def _expire(self, commands: CommandReceiver) -> None:
        self._watchdog = None
        if not self._stop_if_expired(commands, time.monotonic()):
            self._watch(commands)

    def _stop_if_expired(self, commands: CommandReceiver, now_s: float) -> bool:
        has_expired = commands.expire(now_s)
        if has_expired:
            self._report(Level.WARN, f"no command within the time to live; stopping {self._publisher.topic}")
            self._publisher.publish()
        return has_expired

    def _publish(self, payload: bytes, host: str) -> None:
        if self._layout.accepts(payload):
            self._publisher.raw.publish_raw([payload])
        else:
            self._refuse(f"a datagram from {host}: {self._layout.explain(payload)}")

    def _refuse(self, reason: str) -> None:
        suppressed = self._limiter.admit(reason, self._last_s)
        # A reason contains text from the sender, so each datagram could have another one.
        if suppressed is not None and self._budget.admit(self._last_s) is not None:
            also = f" ({suppressed} more since the last such line)" if suppressed else ""
            self._report(Level.WARN, f"ignored {reason}{also}")
