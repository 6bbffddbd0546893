"""All endpoints of one board's node, and how they follow what the board announces.

An endpoint outlives the connection it was announced on. When the board comes back and announces the same
name and type, the endpoint is attached to the new connection and its publisher or subscription never left
the graph; what the board did not announce again by the end of the negotiation is closed.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Iterator
from typing import TypeAlias

from rostether.bridge.board_line import BoardLine
from rostether.bridge.endpoint_factory import EndpointFactory
from rostether.bridge.publisher_endpoint import PublisherEndpoint
from rostether.bridge.reporter import Notices
from rostether.bridge.service_client_endpoint import ServiceClientEndpoint
from rostether.bridge.service_server_endpoint import ServiceServerEndpoint
from rostether.bridge.subscriber_endpoint import SubscriberEndpoint
from rostether.errors import (
    DefinitionError,
    GraphError,
    InvalidNameError,
    RostetherError,
    TypeMismatchError,
)
from rostether.graph.ports import Level
from rostether.rosserial.events import (
    ServiceAnnounced,
    ServiceRole,
    ServiceWithdrawn,
    TopicAnnounced,
    TopicRole,
    TopicWithdrawn,
)
from rostether.transports.backoff import Backoff

TopicEndpoint: TypeAlias = PublisherEndpoint | SubscriberEndpoint
ServiceEndpoint: TypeAlias = ServiceServerEndpoint | ServiceClientEndpoint
Endpoint: TypeAlias = TopicEndpoint | ServiceEndpoint
Role: TypeAlias = TopicRole | ServiceRole
# Topics may come twice under one name, each with its id; a service has one server or caller on a board.
_Key: TypeAlias = tuple[Role, str, int]

# A graph that refuses an endpoint is asked again: first soon, then at most this seldom.
MAX_RETRY_S = 5.0
# Leaving must not hang on a master that does not answer.
CLOSE_LIMIT_S = 1.0


class EndpointTable:
    """The endpoints of one board's node."""

    def __init__(self, factory: EndpointFactory, notices: Notices) -> None:
        self._factory = factory
        self._notices = notices
        self._endpoints: dict[_Key, Endpoint] = {}
        self._attached: set[_Key] = set()
        self._opening: dict[Endpoint, asyncio.Task[None]] = {}
        self._closing: dict[tuple[Role, str], asyncio.Task[None]] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    def __iter__(self) -> Iterator[tuple[Role, Endpoint]]:
        """Yield every endpoint with its role, in the order of their announcement."""
        for key, endpoint in self._endpoints.items():
            yield key[0], endpoint

    def is_attached(self, endpoint: Endpoint) -> bool:
        """Whether the board has announced it on the connection that stands now."""
        return any(self._endpoints.get(key) is endpoint for key in self._attached)

    def announce_topic(self, event: TopicAnnounced, line: BoardLine) -> bool:
        """Serve a topic through a connection; False, and a line that says why, if that is impossible."""
        info = event.info
        key: _Key = (event.role, info.topic_name, info.topic_id)
        found = self._endpoints.get(key) or self._adopt(key)
        if isinstance(found, TopicEndpoint):
            if (found.info.message_type, found.info.md5sum) == (info.message_type, info.md5sum):
                found.attach(line, info)
                self._attach(key, found)
                return True
            self._retire(key)
        made = self._make(info.topic_name, lambda: self._factory.topic(event))
        if isinstance(made, TopicEndpoint):
            made.attach(line, info)
            self._add(key, made)
        return made is not None

    def announce_service(self, event: ServiceAnnounced, line: BoardLine) -> bool:
        """Serve a service through a connection; False, and a line that says why, if that is impossible."""
        key: _Key = (event.role, event.name, 0)
        found = self._endpoints.get(key)
        if isinstance(found, ServiceEndpoint):
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
        """Close what the board no longer has."""
        if isinstance(event, TopicWithdrawn):
            self._retire((event.role, event.info.topic_name, event.info.topic_id))
        else:
            self._retire((event.role, event.name, 0))

    def settle(self) -> None:
        """The negotiation is over: close what was kept from an earlier connection and not announced again."""
        for key in [key for key in self._endpoints if key not in self._attached]:
            self._retire(key)

    def detach_all(self) -> None:
        """The connection ended; keep everything for the next one."""
        for endpoint in self._endpoints.values():
            endpoint.detach()
        self._attached.clear()

    def renew_latched(self) -> None:
        """The board has forgotten everything: bring latched messages to it again."""
        for endpoint in self._endpoints.values():
            self._renew_latched(endpoint)

    def board_is_past_calls(self) -> None:
        """The board showed that it is not busy with a service call."""
        for endpoint in self._endpoints.values():
            if isinstance(endpoint, ServiceServerEndpoint):
                endpoint.board_is_past_call()

    async def close(self) -> None:
        """Close all, in a second at most."""
        for key in list(self._endpoints):
            self._retire(key)
        for task in self._opening.values():
            task.cancel()
        if self._tasks:
            _, late = await asyncio.wait(list(self._tasks), timeout=CLOSE_LIMIT_S)
            for task in late:
                task.cancel()
            if late:
                await asyncio.wait(late)

    def _adopt(self, key: _Key) -> Endpoint | None:
        """Find an endpoint that was announced under another id on an earlier connection."""
        for other in self._endpoints:
            if other[:2] == key[:2] and other not in self._attached:
                endpoint = self._endpoints[key] = self._endpoints.pop(other)
                return endpoint
        return None

    def _make(self, name: str, make: Callable[[], Endpoint]) -> Endpoint | None:
        try:
            return make()
        except RostetherError as error:
            # A definition's own error names its file; all else the board's user must connect with a name.
            self._notices.episode(f"refused {name}", Level.ERROR, f"{name} is not bridged: {error}")
            return None

    def _add(self, key: _Key, endpoint: Endpoint) -> None:
        self._endpoints[key] = endpoint
        self._attached.add(key)
        self._opening[endpoint] = self._run(self._open(key, endpoint))

    def _attach(self, key: _Key, endpoint: Endpoint) -> None:
        newly = key not in self._attached
        self._attached.add(key)
        if newly:
            self._renew_latched(endpoint)

    def _renew_latched(self, endpoint: Endpoint) -> None:
        if (
            isinstance(endpoint, SubscriberEndpoint)
            and endpoint.has_latched_source
            and endpoint not in self._opening
        ):
            self._opening[endpoint] = self._run(self._reopen(endpoint))

    def _retire(self, key: _Key) -> None:
        endpoint = self._endpoints.pop(key, None)
        self._attached.discard(key)
        if endpoint is not None:
            endpoint.detach()
            before = self._closing.get(key[:2])
            self._closing[key[:2]] = self._run(self._close(key[:2], endpoint, before))

    def _run(self, work: Coroutine[object, object, None]) -> asyncio.Task[None]:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _open(self, key: _Key, endpoint: Endpoint) -> None:
        try:
            if key[:2] in self._closing:
                # The graph must see the end of the old before the new of the same name.
                await asyncio.wait([self._closing[key[:2]]])
            await self._keep_opening(endpoint, endpoint.open)
        finally:
            del self._opening[endpoint]

    async def _reopen(self, endpoint: SubscriberEndpoint) -> None:
        try:
            await self._keep_opening(endpoint, endpoint.renew)
        finally:
            del self._opening[endpoint]

    async def _keep_opening(
        self, endpoint: Endpoint, open_it: Callable[[], Coroutine[object, object, None]]
    ) -> None:
        backoff = Backoff(first_s=0.2, limit_s=MAX_RETRY_S)
        name = _name_of(endpoint)
        while endpoint in self._endpoints.values():
            try:
                await open_it()
            except (DefinitionError, InvalidNameError, TypeMismatchError) as error:
                self._notices.episode(f"refused {name}", Level.ERROR, f"{name} is not bridged: {error}")
                return
            except GraphError as error:
                self._notices.episode(
                    f"refused {name}", Level.ERROR, f"{name} is not bridged yet: {error}; trying again"
                )
                await asyncio.sleep(backoff.next_delay_s())
            else:
                self._notices.end_episode(f"refused {name}")
                return

    async def _close(
        self, name: tuple[Role, str], endpoint: Endpoint, before: asyncio.Task[None] | None
    ) -> None:
        if before is not None:
            await asyncio.wait([before])
        opening = self._opening.get(endpoint)
        if opening is not None:
            await asyncio.wait([opening])
        try:
            await endpoint.close()
        except GraphError as error:
            self._notices.episode(
                "withdraw", Level.WARN, f"{_name_of(endpoint)} may still be listed: {error}"
            )


def _name_of(endpoint: Endpoint) -> str:
    return endpoint.info.name if isinstance(endpoint.info, ServiceAnnounced) else endpoint.info.topic_name


def _service_type(info: ServiceAnnounced) -> tuple[str, str, str]:
    return info.type, info.request.md5sum, info.response.md5sum
