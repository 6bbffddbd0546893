"""This node's registrations with the master; they are repeated after the master has restarted.

A master that restarts has lost all registrations, and notifies no node. So every few seconds the node
requests its own address. Without an answer, the master is unreachable. If it does not know the node's name,
it has restarted. If it returns another address, another node has the name now.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterator
from contextlib import suppress
from enum import Enum
from weakref import WeakSet, WeakValueDictionary
from zlib import crc32

from rostether.errors import GraphError, MasterUnreachableError, UnknownNameError
from rostether.ros1.node.master_client import MasterClient

# One small call each; a restarted master has the node's topics again within about this time.
DEFAULT_CHECK_INTERVAL_S = 2.0

# The concurrent calls to the master while a node leaves, and their time limit. 100 boards of 100 topics that
# leave together must not need 10 KB of memory for each topic; a master that hangs must not delay the node.
UNREGISTERED_AT_ONCE = 2
UNREGISTER_TIMEOUT_S = 2.0

# A thousand nodes of one process with a check every 2 s would use a sixth of a core, and the master the same.
MAX_CHECKS_HZ = 200

_log = logging.getLogger("rostether.ros1")


class OwnKind(Enum):
    """The kinds of endpoints that a node registers."""

    PUBLISHER = "publisher"
    SUBSCRIBER = "subscriber"
    SERVICE = "service"


# The registrations of this process that are checked.
_watching: WeakSet[OwnRegistrations] = WeakSet()


class OwnRegistrations:
    """Keeps the master's registrations equal to the node's table.

    All nodes of one process together make at most MAX_CHECKS_HZ checks a second.
    `on_publishers` gets the URIs of a subscribed topic's publishers; `register_more` runs after the table was
    registered again; `on_replaced` is called when another node has taken the name.
    """

    def __init__(
        self,
        master: MasterClient,
        *,
        node_uri: str,
        service_uri: str,
        on_publishers: Callable[[str, list[str]], None],
        register_more: Callable[[], Awaitable[None]],
        on_replaced: Callable[[str], None],
    ) -> None:
        self._master = master
        self._node_uri = node_uri
        self._service_uri = service_uri
        self._on_publishers = on_publishers
        self._register_more = register_more
        self._on_replaced = on_replaced
        # The type name of each registration; empty for services, whose types the master does not store.
        self._wanted: dict[tuple[OwnKind, str], str] = {}
        # No longer wanted, but perhaps still in the master: a removal was canceled, or is in progress.
        self._left_over: set[tuple[OwnKind, str]] = set()
        self._locks: WeakValueDictionary[tuple[OwnKind, str], asyncio.Lock] = WeakValueDictionary()
        self._is_behind = False
        self._watch: asyncio.Task[None] | None = None

    def start_watch(self, interval_s: float) -> None:
        """Start to check the registrations."""
        self._watch = asyncio.ensure_future(self._watch_master(interval_s))

    async def add(self, kind: OwnKind, name: str, type_name: str = "") -> None:
        """Register, later if the master is unreachable now. Raises GraphError if the master refuses."""
        self._wanted[kind, name] = type_name
        try:
            await self._settle(kind, name)
        except MasterUnreachableError as error:
            if not self._is_behind:
                self._is_behind = True
                _log.warning("%s will register when the master is back: %s", self._master.caller_id, error)

    async def remove(self, kind: OwnKind, name: str) -> None:
        """Unregister. If canceled, `close` unregisters instead."""
        if self._wanted.pop((kind, name), None) is not None:
            self._left_over.add((kind, name))
            await self._unregister(kind, name)

    async def close(self) -> None:
        """Stop the checks, and unregister all that is left, unless the master does not answer in time."""
        if self._watch is not None:
            self._watch.cancel()
            await asyncio.wait((self._watch,))
            _watching.discard(self)
        self._left_over.update(self._wanted)
        self._wanted.clear()
        remaining = iter(list(self._left_over))
        await asyncio.gather(*(self._unregister_all(remaining) for _ in range(UNREGISTERED_AT_ONCE)))

    async def _unregister_all(self, remaining: Iterator[tuple[OwnKind, str]]) -> None:
        with suppress(TimeoutError):
            for kind, name in remaining:
                async with asyncio.timeout(UNREGISTER_TIMEOUT_S):
                    await self._unregister(kind, name)

    async def _unregister(self, kind: OwnKind, name: str) -> None:
        try:
            await self._settle(kind, name)
        except GraphError as error:
            # A master that has ended, or has lost the registrations, needs no call.
            _log.debug("%s", error)
        self._left_over.discard((kind, name))

    async def _settle(self, kind: OwnKind, name: str) -> None:
        """Update the master's entry to the current table; one call at a time, so that the last one counts."""
        lock = self._locks.setdefault((kind, name), asyncio.Lock())
        async with lock:
            type_name = self._wanted.get((kind, name))
            if kind is OwnKind.PUBLISHER:
                if type_name is None:
                    await self._master.unregister_publisher(name, self._node_uri)
                else:
                    await self._master.register_publisher(name, type_name, self._node_uri)
            elif kind is OwnKind.SUBSCRIBER:
                if type_name is None:
                    await self._master.unregister_subscriber(name, self._node_uri)
                else:
                    uris = await self._master.register_subscriber(name, type_name, self._node_uri)
                    self._on_publishers(name, uris)
            elif type_name is None:
                await self._master.unregister_service(name, self._service_uri)
            else:
                await self._master.register_service(name, self._service_uri, self._node_uri)

    async def _register_all(self) -> None:
        for kind, name in list(self._wanted):
            await self._settle(kind, name)
        await self._register_more()

    async def _watch_master(self, interval_s: float) -> None:
        _watching.add(self)
        is_away = False
        # Nodes check at different times: a hundred simultaneous checks would delay the boards' messages.
        wait_s = interval_s * crc32(self._master.caller_id.encode()) / 2**32
        while True:
            await asyncio.sleep(wait_s)
            wait_s = max(interval_s, len(_watching) / MAX_CHECKS_HZ)
            try:
                if await self._check():
                    _log.warning(
                        "%s: the ROS master had no registration of this node; registered again",
                        self._master.caller_id,
                    )
                elif is_away:
                    _log.warning("%s: the ROS master is back", self._master.caller_id)
                is_away = False
            except MasterUnreachableError as error:
                if not is_away:
                    _log.warning(
                        "%s keeps its connections until the master is back: %s", self._master.caller_id, error
                    )
                is_away = True
            except GraphError as error:
                _log.warning("%s cannot register again: %s", self._master.caller_id, error)

    async def _check(self) -> bool:
        """Check the node's registration; return True if everything had to be registered again."""
        try:
            uri = await self._master.lookup_node(self._master.caller_id)
        except UnknownNameError:
            uri = ""
        if uri and uri != self._node_uri:
            self._on_replaced(f"another node at {uri} has taken the name {self._master.caller_id}")
            return False
        if uri and not self._is_behind:
            return False
        await self._register_all()
        self._is_behind = False
        return True
