"""Creates the endpoint for a board's announcement, or raises an error with the reason why there is none."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

from rostether.bridge.endpoint.publisher import PublisherEndpoint
from rostether.bridge.endpoint.service_client import ServiceClientEndpoint
from rostether.bridge.endpoint.service_server import ServiceServerEndpoint
from rostether.bridge.endpoint.subscriber import SubscriberEndpoint
from rostether.bridge.reporter import Notices
from rostether.bridge.settings import BridgeSettings
from rostether.errors import TypeMismatchError
from rostether.graph.ports import Graph
from rostether.mechanisms.rate_limits import TokenBucket
from rostether.ports.settings import NO_SETTINGS, DeviceSettings
from rostether.rosserial.events import ServiceAnnounced, ServiceRole, TopicAnnounced, TopicRole
from rostether.serde.store import TypeStore

# The search for the difference takes about 30 ms: it must not run again whenever the board reconnects.
MAX_MISMATCHES = 64

# By the role of an endpoint: the field of `Access` with the names that it may have.
ACCESS_KINDS: Mapping[TopicRole | ServiceRole, str] = {
    TopicRole.PUBLISHER: "publish",
    TopicRole.SUBSCRIBER: "subscribe",
    ServiceRole.SERVER: "serve",
    ServiceRole.CLIENT: "call",
}


class EndpointFactory:
    """Makes the endpoints of one board's node."""

    def __init__(
        self,
        graph: Graph,
        store: TypeStore,
        notices: Notices,
        settings: BridgeSettings,
        device: DeviceSettings = NO_SETTINGS,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._graph = graph
        self._store = store
        self._notices = notices
        self._settings = settings
        self._access = device.access
        # One limit for all topics: a flood costs the same, however many topics it uses.
        self._admit: Callable[[int], int] | None = None
        if settings.messages_hz is not None:
            bucket = TokenBucket(settings.messages_hz, settings.messages_hz, clock())
            self._admit = lambda count: bucket.admit(count, clock())
        self._queue_depths = {graph.resolve(name): depth for name, depth in device.queue_depths.items()}
        self._mismatches: dict[tuple[str, str], str] = {}

    def topic(self, event: TopicAnnounced) -> PublisherEndpoint | SubscriberEndpoint:
        """Make a topic's endpoint.

        Raises DefinitionError, TypeMismatchError, InvalidNameError, AccessDeniedError.
        """
        info = event.info
        name = self._graph.resolve(info.topic_name)
        self._access.check(ACCESS_KINDS[event.role], name)
        known = self._store.registry.message_type(info.message_type)
        self._check_md5sum(info.message_type, info.md5sum, known.md5sum)
        if event.role is TopicRole.PUBLISHER:
            return PublisherEndpoint(
                info, self._store, self._graph, self._notices, self._settings, self._admit
            )
        depth = self._queue_depths.get(name)
        return SubscriberEndpoint(info, self._store, self._graph, self._notices, depth)

    def service(self, event: ServiceAnnounced) -> ServiceServerEndpoint | ServiceClientEndpoint:
        """Make a service's endpoint.

        Raises DefinitionError, TypeMismatchError, InvalidNameError, AccessDeniedError.
        """
        self._access.check(ACCESS_KINDS[event.role], self._graph.resolve(event.name))
        service_type = self._store.registry.service_type(event.type)
        for announced, known in (
            (event.request, service_type.request),
            (event.response, service_type.response),
        ):
            self._check_md5sum(known.name, announced.md5sum, known.md5sum)
        kind = ServiceServerEndpoint if event.role is ServiceRole.SERVER else ServiceClientEndpoint
        return kind(event, self._store, self._graph, self._notices, self._settings)

    def _check_md5sum(self, type_name: str, announced: str, known: str) -> None:
        if announced == known:
            return
        asked = (type_name, announced)
        if asked not in self._mismatches:
            from rostether.msgdef.mismatch import explain_mismatch  # only needed for a mismatch

            if len(self._mismatches) >= MAX_MISMATCHES:
                self._mismatches.clear()
            self._mismatches[asked] = explain_mismatch(self._store.registry, type_name, announced)
        raise TypeMismatchError(self._mismatches[asked])
