"""What this node has registered with the master, and keeping it so when the master forgets.

A ROS 1 master that restarts knows nobody, and nobody is told. So every few seconds we ask it for our own
address: no answer means it is away, an unknown name that it has restarted, another address that another
node has taken our name.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable

from rostether.errors import GraphError, MasterUnreachableError, UnknownNameError
from rostether.ros1.node.master_client import MasterClient

DEFAULT_CHECK_INTERVAL_S = 2.0
"""One small call each; a master that came back has our topics again within about this time."""

_log = logging.getLogger("rostether.ros1")


class Registrations:
    """Keeps a table of registrations and the master's in step.

    `on_publishers` gets the URIs of publishers of a topic we subscribed to; `register_more` runs after a
    master has been given the table again; `on_replaced` is called when another node has taken our name.
    """

    def __init__(
        self,
        master: MasterClient,
        node_uri: str,
        *,
        on_publishers: Callable[[str, list[str]], None],
        register_more: Callable[[], Awaitable[None]],
        on_replaced: Callable[[str], None],
    ) -> None:
        self._master = master
        self._node_uri = node_uri
        self._on_publishers = on_publishers
        self._register_more = register_more
        self._on_replaced = on_replaced
        self._publishers: dict[str, str] = {}
        self._subscribers: dict[str, str] = {}
        self._services: dict[str, str] = {}
        self._is_behind = False
        self._watch: asyncio.Task[None] | None = None

    def start_watch(self, interval_s: float) -> None:
        """Begin to look after the registrations."""
        self._watch = asyncio.ensure_future(self._watch_master(interval_s))

    async def add_publisher(self, topic: str, type_name: str) -> None:
        """Register a publisher; a master that is away gets it later."""
        self._publishers[topic] = type_name
        await self._try(self._register_publisher(topic))

    async def add_subscriber(self, topic: str, type_name: str) -> None:
        """Register a subscriber; a master that is away gets it later."""
        self._subscribers[topic] = type_name
        await self._try(self._register_subscriber(topic))

    async def add_service(self, service: str, service_uri: str) -> None:
        """Register a service; a master that is away gets it later."""
        self._services[service] = service_uri
        await self._try(self._master.register_service(service, service_uri, self._node_uri))

    async def remove_publisher(self, topic: str) -> None:
        """Unregister a publisher."""
        if self._publishers.pop(topic, None) is not None:
            await _quietly(self._master.unregister_publisher(topic, self._node_uri))

    async def remove_subscriber(self, topic: str) -> None:
        """Unregister a subscriber."""
        if self._subscribers.pop(topic, None) is not None:
            await _quietly(self._master.unregister_subscriber(topic, self._node_uri))

    async def remove_service(self, service: str) -> None:
        """Unregister a service."""
        if (service_uri := self._services.pop(service, None)) is not None:
            await _quietly(self._master.unregister_service(service, service_uri))

    async def close(self) -> None:
        """Stop looking, and unregister what is left, all at once."""
        if self._watch is not None:
            self._watch.cancel()
            await asyncio.wait((self._watch,))
        await asyncio.gather(
            *(self.remove_publisher(topic) for topic in list(self._publishers)),
            *(self.remove_subscriber(topic) for topic in list(self._subscribers)),
            *(self.remove_service(service) for service in list(self._services)),
        )

    async def _register_publisher(self, topic: str) -> None:
        await self._master.register_publisher(topic, self._publishers[topic], self._node_uri)

    async def _register_subscriber(self, topic: str) -> None:
        uris = await self._master.register_subscriber(topic, self._subscribers[topic], self._node_uri)
        self._on_publishers(topic, uris)

    async def _try(self, registration: Awaitable[None]) -> None:
        try:
            await registration
        except MasterUnreachableError as error:
            if not self._is_behind:
                self._is_behind = True
                _log.warning("%s: %s; registering when it is back", self._master.caller_id, error)

    async def _register_all(self) -> None:
        for topic in list(self._publishers):
            await self._register_publisher(topic)
        for topic in list(self._subscribers):
            await self._register_subscriber(topic)
        for service, service_uri in list(self._services.items()):
            await self._master.register_service(service, service_uri, self._node_uri)
        await self._register_more()

    async def _watch_master(self, interval_s: float) -> None:
        is_away = False
        while True:
            await asyncio.sleep(interval_s)
            try:
                if await self._check():
                    _log.warning(
                        "%s: the ROS master knew us no more, registered again", self._master.caller_id
                    )
                elif is_away:
                    _log.warning("%s: the ROS master is back", self._master.caller_id)
                is_away = False
            except MasterUnreachableError as error:
                if not is_away:
                    _log.warning("%s: %s; connections stay, waiting for it", self._master.caller_id, error)
                is_away = True
            except GraphError as error:
                _log.warning("%s: cannot register again: %s", self._master.caller_id, error)

    async def _check(self) -> bool:
        """Look at our own registration; True when everything had to be registered again."""
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


async def _quietly(call: Awaitable[None]) -> None:
    try:
        await call
    except GraphError as error:
        # A master that is gone, or has forgotten us, needs no unregistering.
        _log.debug("%s", error)
