"""rosapi's services about the graph: its topics, nodes and services, with their types."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Final

from rostether.errors import RostetherError
from rostether.gateways.rosbridge.service_types import AskServer
from rostether.gateways.rosbridge.settings import RosbridgeSettings, matches
from rostether.gateways.type_names import long_type, short_type
from rostether.graph.ports import Graph, ServiceEntry, Snapshot
from rostether.msgdef.interface import ANY_TYPE
from rostether.msgdef.registry import Registry

if TYPE_CHECKING:
    from rostether.ros2.types.type_support import Ros2Types

# How long one server may take to send its type or host; a server may hang.
_ASK_LIMIT_S: Final = 3.0

# The limit of concurrent requests to servers: each opens a connection, and file descriptors are limited.
_MAX_ASKED: Final = 32

# Topics whose definitions one answer may contain: about 10 MB of text.
_MAX_TEXT_TOPICS: Final = 2000

_ACTION_TOPICS: Final = ("goal", "cancel", "status", "feedback", "result")
_ROS2_ACTION_TOPICS: Final = ("/_action/status", "/_action/feedback")


class GraphAnswers:
    """Answers requests about the graph.

    Clients see only the names that the `settings` allow. `ask_type` and `ask_host` ask the server of a
    service.
    """

    def __init__(
        self,
        graph: Graph,
        registry: Registry,
        settings: RosbridgeSettings,
        *,
        is_ros2: bool,
        ask_type: AskServer | None,
        ask_host: AskServer | None,
    ) -> None:
        # The types of the gateway's own services.
        self.known_types: Mapping[str, str] = {}
        self._graph = graph
        self._registry = registry
        self._is_ros2 = is_ros2
        self._settings = settings
        self._ask_type = ask_type
        self._ask_host = ask_host

    async def topics(self) -> tuple[list[str], list[str]]:
        """Return all topics and, in the same order, their types."""
        found = await self._topic_types()
        return list(found), list(found.values())

    async def topics_and_texts(self) -> tuple[list[str], list[str], list[str]]:
        """Return all topics, their types, and the full texts of the types."""
        found = dict(list((await self._topic_types()).items())[:_MAX_TEXT_TOPICS])
        texts = {name: self._text(name) for name in set(found.values())}
        return list(found), list(found.values()), [texts[name] for name in found.values()]

    async def topics_for_type(self, type_name: str) -> list[str]:
        """Return the topics of a type, whose name is spelled as in ROS 1 or ROS 2."""
        wanted = short_type(type_name)
        return [topic for topic, name in (await self._topic_types()).items() if short_type(name) == wanted]

    async def topic_type(self, topic: str) -> str:
        """Return a topic's type, empty if it is unknown."""
        return (await self._topic_types()).get(self._graph.resolve(topic), "")

    async def publishers(self, topic: str) -> list[str]:
        """Return the nodes that publish a topic."""
        found = (await self._graph.snapshot()).topics.get(self._topic(topic))
        return list(found.publishers) if found is not None else []

    async def subscribers(self, topic: str) -> list[str]:
        """Return the nodes that subscribe to a topic."""
        found = (await self._graph.snapshot()).topics.get(self._topic(topic))
        return list(found.subscribers) if found is not None else []

    async def nodes(self) -> list[str]:
        """Return all nodes."""
        return list((await self._graph.snapshot()).nodes)

    async def node_details(self, node: str) -> tuple[list[str], list[str], list[str]]:
        """Return a node's subscriptions, publications and services."""
        snapshot = await self._graph.snapshot()
        name = node if node.startswith("/") else f"/{node}"
        topics = [each for each in snapshot.topics.values() if self._allows_topic(each.name)]
        return (
            [each.name for each in topics if name in each.subscribers],
            [each.name for each in topics if name in each.publishers],
            [each.name for each in self._services(snapshot) if name in each.providers],
        )

    async def services(self) -> list[str]:
        """Return all services."""
        return [each.name for each in self._services(await self._graph.snapshot())]

    async def services_for_type(self, type_name: str) -> list[str]:
        """Return the services of a type, without those whose servers do not answer."""
        return [each.name for each in await self._services_of(type_name)]

    async def service_type(self, service: str) -> str:
        """Return a service's type, empty if it is unknown."""
        found = await self._service(service)
        return (await self._types_of([found]))[0] if found is not None else ""

    async def service_node(self, service: str) -> str:
        """Return the node that offers a service, an empty string if there is none."""
        found = await self._service(service)
        return found.providers[0] if found is not None and found.providers else ""

    async def service_providers(self, wanted: str) -> list[str]:
        """Return the nodes that offer a service, given its name or, as rosapi documents, its type."""
        if wanted.count("/") and not wanted.startswith("/"):
            found = {node for each in await self._services_of(wanted) for node in each.providers}
            if found:
                return sorted(found)
        service = await self._service(wanted)
        return list(service.providers) if service is not None else []

    async def service_host(self, service: str) -> str:
        """Return the machine of a service's server, empty if the graph does not know it."""
        found = await self._service(service)
        return await self._asked(self._ask_host, found.name) if found is not None else ""

    async def action_servers(self) -> list[str]:
        """Return the available actions: those whose five topics exist."""
        snapshot = await self._graph.snapshot()
        if self._is_ros2:
            found = {name.partition("/_action/")[0] for name in snapshot.topics if "/_action/" in name}
            return sorted(
                name
                for name in found
                if all(f"{name}{topic}" in snapshot.topics for topic in _ROS2_ACTION_TOPICS)
                and self._allows_topic(name)
            )
        names = {name.removesuffix("/goal") for name in snapshot.topics if name.endswith("/goal")}
        return sorted(
            name
            for name in names
            if all(f"{name}/{each}" in snapshot.topics for each in _ACTION_TOPICS)
            and self._allows_topic(f"{name}/goal")
        )

    def _allows_topic(self, name: str) -> bool:
        return matches(name, self._settings.topics_glob)

    def _allows_service(self, name: str) -> bool:
        return matches(name, self._settings.services_glob)

    def _topic(self, topic: str) -> str:
        name = self._graph.resolve(topic)
        return name if self._allows_topic(name) else ""

    async def _topic_types(self) -> dict[str, str]:
        topics = (await self._graph.snapshot()).topics.values()
        return {each.name: self._spelled(each.type) for each in topics if self._allows_topic(each.name)}

    def _spelled(self, type_name: str, kind: str = "msg") -> str:
        # Several types on one ROS 2 topic are separated by spaces.
        first = type_name.partition(" ")[0]
        if first == ANY_TYPE:
            return ""
        return long_type(first, kind) if self._is_ros2 else short_type(first)

    def _text(self, type_name: str) -> str:
        if not type_name:
            return ""
        try:
            message_type = self._registry.message_type(short_type(type_name))
            return self._ros2_types.full_text(message_type) if self._is_ros2 else message_type.definition
        except RostetherError as error:
            return f"# failed to get full definition text for {type_name}: {error}"

    @cached_property
    def _ros2_types(self) -> Ros2Types:
        from rostether.ros2.types.native_types import types_of

        return types_of(self._registry)

    def _services(self, snapshot: Snapshot) -> list[ServiceEntry]:
        return [each for each in snapshot.services.values() if self._allows_service(each.name)]

    async def _services_of(self, type_name: str) -> list[ServiceEntry]:
        wanted = short_type(type_name)
        services = self._services(await self._graph.snapshot())
        types = await self._types_of(services)
        return [
            each for each, name in zip(services, types, strict=True) if name and short_type(name) == wanted
        ]

    async def _service(self, service: str) -> ServiceEntry | None:
        found = (await self._graph.snapshot()).services.get(self._graph.resolve(service))
        return found if found is not None and self._allows_service(found.name) else None

    async def _types_of(self, services: Iterable[ServiceEntry]) -> list[str]:
        slots = asyncio.Semaphore(_MAX_ASKED)

        async def find(service: ServiceEntry) -> str:
            known = self.known_types.get(service.name, service.type)
            if known != ANY_TYPE:
                return self._spelled(known, "srv")
            async with slots:
                return self._spelled(await self._asked(self._ask_type, service.name), "srv")

        return await asyncio.gather(*map(find, services))

    async def _asked(self, ask: AskServer | None, service: str) -> str:
        if ask is None:
            return ""
        try:
            async with asyncio.timeout(_ASK_LIMIT_S):
                return await ask(service)
        except (RostetherError, TimeoutError):
            return ""
