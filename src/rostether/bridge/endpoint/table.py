"""All endpoints of one board's node, which follow the board's announcements.

An endpoint is kept when its connection ends. When the board comes back and announces the same
name and type, the endpoint is attached to the new connection. Its publisher or subscription has stayed in the
graph. Endpoints that the board did not announce again by the end of the negotiation are closed. A new
sketch may use a name with another type and any id: the old endpoint is closed before the new one opens.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeAlias

from rostether.bridge.endpoint.board_line import BoardLine
from rostether.bridge.endpoint.factory import EndpointFactory
from rostether.bridge.endpoint.openings import (
    Endpoint,
    EndpointOpenings,
    Role,
    ServiceEndpoint,
    TopicEndpoint,
    name_of,
)
from rostether.bridge.endpoint.service_server import ServiceServerEndpoint
from rostether.bridge.endpoint.subscriber import SubscriberEndpoint
from rostether.bridge.reporter import Notices
from rostether.errors import RostetherError
from rostether.graph.ports import Level
from rostether.rosserial.events import (
    ServiceAnnounced,
    ServiceWithdrawn,
    TopicAnnounced,
    TopicRole,
    TopicWithdrawn,
)
from rostether.rosserial.packets import TopicInfo

# Topics may come twice under one name, each with its id; a service has one server or caller on a board.
_Key: TypeAlias = tuple[Role, str, int]

# The limit of refused endpoints: a board that always announces new ones must not fill the memory.
MAX_REFUSED = 256


class EndpointTable:
    """The endpoints of one board's node."""

    def __init__(self, factory: EndpointFactory, notices: Notices) -> None:
        self._factory = factory
        self._notices = notices
        self._endpoints: dict[_Key, Endpoint] = {}
        self._attached: set[_Key] = set()
        self._openings = EndpointOpenings(notices)

        # By name: the reason why an announcement on this connection is not served.
        self.refused: dict[str, RostetherError] = {}
        # Endpoints that another type of the same name has replaced, and that were not withdrawn yet. Until
        # the negotiation ends, it is unknown whether the board still has them.
        self._displaced: dict[_Key, Endpoint] = {}

    def __iter__(self) -> Iterator[tuple[Role, Endpoint]]:
        """Yield every endpoint with its role, in the order of their announcement."""
        for key, endpoint in self._endpoints.items():
            yield key[0], endpoint

    @property
    def unopened(self) -> dict[str, str]:
        """By name: the reason why an announced endpoint is not in the graph."""
        return {name_of(endpoint): reason for endpoint, reason in self._openings.reasons.items()}

    def is_attached(self, endpoint: Endpoint) -> bool:
        """Return whether the board has announced it on the current connection."""
        return any(self._endpoints.get(key) is endpoint for key in self._attached)

    def announced_topics(self) -> list[str]:
        """Return the topics that the board has announced on this connection, bridged or not."""
        names = [name for role, name, _ in self._attached if isinstance(role, TopicRole)]
        return sorted({*names, *self.refused})

    def announce_topic(self, event: TopicAnnounced, line: BoardLine) -> bool:
        """Serve a topic through a connection; if that is impossible, report why and return False."""
        info = event.info
        key: _Key = (event.role, info.topic_name, info.topic_id)
        self._displaced.pop(key, None)
        self._displace_other_types(key, info)
        found = self._endpoints.get(key) or self._adopt(key)
        if isinstance(found, TopicEndpoint):
            found.attach(line, info)
            self._attach(key, found)
            return True
        made = self._make(info.topic_name, lambda: self._factory.topic(event))
        if isinstance(made, TopicEndpoint):
            made.attach(line, info)
            self._add(key, made)
        return made is not None

    def announce_service(self, event: ServiceAnnounced, line: BoardLine) -> bool:
        """Serve a service through a connection; if that is impossible, report why and return False."""
        key: _Key = (event.role, event.name, 0)
        found = self._endpoints.get(key)
        if isinstance(found, ServiceEndpoint):
            if found.info == event and key in self._attached:
                return True
            if _service_type(found.info) == _service_type(event):
                found.attach(line, event)
                self._attach(key, found)
                return True
            self._retire(key)
        made = self._make(event.name, lambda: self._factory.service(event))
        if isinstance(made, ServiceEndpoint):
            made.attach(line, event)
            self._add(key, made)
        return made is not None

    def withdraw(self, event: TopicWithdrawn | ServiceWithdrawn) -> None:
        """Close endpoints that the board no longer has."""
        self.refused.pop(event.info.topic_name if isinstance(event, TopicWithdrawn) else event.name, None)
        if isinstance(event, TopicWithdrawn):
            key: _Key = (event.role, event.info.topic_name, event.info.topic_id)
            self._displaced.pop(key, None)
            self._retire(key)
            return
        key = (event.role, event.name, 0)
        endpoint = self._endpoints.get(key)
        # A service that returned with other ids or another type is already in the table.
        if isinstance(endpoint, ServiceEndpoint) and _service_ids(endpoint.info) == _service_ids(event):
            self._retire(key)

    def settle(self) -> None:
        """End the negotiation: close kept endpoints that were not announced again."""
        for key in [key for key in self._endpoints if key not in self._attached]:
            self._retire(key)
        displaced, self._displaced = self._displaced, {}
        for endpoint in displaced.values():
            name = name_of(endpoint)
            self._notices.report_episode(
                f"two types {name}",
                Level.ERROR,
                f"the board has {name} with two types, and only the last is bridged; give one of them "
                "another name in the sketch",
            )

    def detach_all(self) -> None:
        """End the connection; keep all endpoints for the next one."""
        for endpoint in self._endpoints.values():
            endpoint.detach()
        self._attached.clear()
        self._displaced.clear()
        self.refused.clear()

    def renew_latched(self) -> None:
        """Subscribe again after a reset of the board, so that it receives latched messages again."""
        for endpoint in self._endpoints.values():
            self._renew_latched(endpoint)

    def time_requested(self, now_s: float) -> None:
        """Handle a time request: the board may have finished a service call without an answer."""
        for endpoint in self._servers():
            endpoint.time_requested(now_s)

    def device_reset(self) -> None:
        """Fail the calls in flight."""
        for endpoint in self._servers():
            endpoint.fail_call("reset")

    async def close(self) -> None:
        """Close all endpoints within a second."""
        for key in list(self._endpoints):
            self._retire(key)
        await self._openings.finish()

    def _servers(self) -> list[ServiceServerEndpoint]:
        return [each for each in self._endpoints.values() if isinstance(each, ServiceServerEndpoint)]

    def _adopt(self, key: _Key) -> Endpoint | None:
        """Find an endpoint that was announced under another id on an earlier connection."""
        for other in self._endpoints:
            if other[:2] == key[:2] and other not in self._attached:
                endpoint = self._endpoints[key] = self._endpoints.pop(other)
                return endpoint
        return None

    def _displace_other_types(self, key: _Key, info: TopicInfo) -> None:
        """Close the endpoints of this name and role with another type: a node has one type for each topic."""
        for other, endpoint in list(self._endpoints.items()):
            if other[:2] == key[:2] and isinstance(endpoint, TopicEndpoint) and not _is_type(endpoint, info):
                if other in self._attached and other != key:
                    self._displaced[other] = endpoint
                self._retire(other)

    def _make(self, name: str, make: Callable[[], Endpoint]) -> Endpoint | None:
        try:
            made = make()
        except RostetherError as error:
            if len(self.refused) < MAX_REFUSED:
                self.refused[name] = error
            # An error in a definition names its file; every other error needs the name of the topic.
            self._notices.report_episode(f"refused {name}", Level.ERROR, f"{name} is not bridged: {error}")
            return None
        self.refused.pop(name, None)
        return made

    def _add(self, key: _Key, endpoint: Endpoint) -> None:
        self._endpoints[key] = endpoint
        self._attached.add(key)
        self._openings.open(key[:2], endpoint)

    def _attach(self, key: _Key, endpoint: Endpoint) -> None:
        is_new = key not in self._attached
        self._attached.add(key)
        if is_new:
            self._renew_latched(endpoint)

    def _renew_latched(self, endpoint: Endpoint) -> None:
        if isinstance(endpoint, SubscriberEndpoint) and endpoint.has_latched_source:
            self._openings.renew(endpoint)

    def _retire(self, key: _Key) -> None:
        endpoint = self._endpoints.pop(key, None)
        self._attached.discard(key)
        if endpoint is not None:
            endpoint.detach()
            self._openings.close(key[:2], endpoint)


def _is_type(endpoint: TopicEndpoint, info: TopicInfo) -> bool:
    return (endpoint.info.message_type, endpoint.info.md5sum) == (info.message_type, info.md5sum)


def _service_ids(info: ServiceAnnounced | ServiceWithdrawn) -> tuple[int, int]:
    return info.request.topic_id, info.response.topic_id


def _service_type(info: ServiceAnnounced) -> tuple[str, str, str]:
    return info.type, info.request.md5sum, info.response.md5sum
