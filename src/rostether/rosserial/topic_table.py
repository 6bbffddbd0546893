"""The endpoints that a device has announced, by direction and id, and the services that they form."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple, TypeAlias

from msgspec import Struct

from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import (
    HostEvent,
    ServiceAnnounced,
    ServiceRole,
    ServiceWithdrawn,
    TopicAnnounced,
    TopicRole,
    TopicWithdrawn,
)
from rostether.rosserial.frame import MAX_PAYLOAD_BYTES
from rostether.rosserial.frame_decoder import PayloadLimits
from rostether.rosserial.packets import TopicInfo

# The largest payload that makes sense from a device on each reserved id.
CONTROL_LIMITS = {
    **dict.fromkeys(ids.ANNOUNCEMENTS, 800),  # three strings of at most 255 bytes, and 18 bytes
    ids.PARAMETER: 260,
    ids.LOG: 1024,  # a line longer than a board's buffer is not a log line
    ids.TIME: 8,
}

Announcement: TypeAlias = tuple[int, TopicInfo]

_ROLES = {ids.PUBLISHER: TopicRole.PUBLISHER, ids.SUBSCRIBER: TopicRole.SUBSCRIBER}
# The kinds of announcements of a service: of its request, and of its response.
SERVICE_KINDS = {
    ServiceRole.SERVER: (ids.SERVICE_SERVER_REQUEST, ids.SERVICE_SERVER_RESPONSE),
    ServiceRole.CLIENT: (ids.SERVICE_CLIENT_REQUEST, ids.SERVICE_CLIENT_RESPONSE),
}


class EndpointKey(NamedTuple):
    """Identifies an endpoint: one id may belong to two endpoints, one in each direction."""

    sends: bool
    topic_id: int


class _Endpoint(Struct):
    kind: int
    info: TopicInfo
    largest_payload: int
    is_current: bool = True


def key_of(kind: int, info: TopicInfo) -> EndpointKey:
    """Return the key of an endpoint announced on reserved id `kind`."""
    return EndpointKey(kind in ids.DEVICE_SENDS_ON, info.topic_id)


class TopicTable:
    """The endpoints of one device; each announcement returns its changes as events."""

    def __init__(
        self, max_endpoints: int, fixed_size: Callable[[TopicInfo], int | None] | None = None
    ) -> None:
        self._max_endpoints = max_endpoints
        self._fixed_size = fixed_size
        self._endpoints: dict[EndpointKey, _Endpoint] = {}
        self._services: dict[tuple[ServiceRole, int, int], ServiceAnnounced] = {}

        # None after a change, until the next use.
        self._limits: PayloadLimits | None = None
        # The largest payload that may be sent to the device now, by id.
        self.send_limits: dict[int, int] = {}
        # Ids that the device sends on.
        self.senders: set[int] = set()

    def keys(self) -> frozenset[EndpointKey]:
        """Return the keys of all endpoints."""
        return frozenset(self._endpoints)

    @property
    def limits(self) -> PayloadLimits:
        """The limits of the device's payloads; the same object until an endpoint changes."""
        if self._limits is None:
            self._limits = self._make_limits()
        return self._limits

    def incomplete_services(self) -> list[Announcement]:
        """Return the requests without a response and the responses without a request, each with its kind."""
        paired = {
            key
            for pair in self._services.values()
            for key in (
                key_of(SERVICE_KINDS[pair.role][0], pair.request),
                key_of(SERVICE_KINDS[pair.role][1], pair.response),
            )
        }
        return [
            (endpoint.kind, endpoint.info)
            for key, endpoint in self._endpoints.items()
            if endpoint.kind not in _ROLES and key not in paired
        ]

    @property
    def input_buffer_bytes(self) -> int | None:
        """The size of the device's input buffer, which limits all payloads to it; None without endpoints.

        Publishers announce the output buffer instead; without subscribers, both are considered equal.
        """
        by_direction = {
            sends: [entry.info.buffer_size for key, entry in self._endpoints.items() if key.sends is sends]
            for sends in (False, True)
        }
        sizes = by_direction[False] or by_direction[True]
        return min(sizes) if sizes else None

    def is_known(self, kind: int, info: TopicInfo) -> bool:
        """Return whether exactly this was announced before."""
        known = self._endpoints.get(key_of(kind, info))
        return known is not None and (known.kind, known.info) == (kind, info)

    def announce(self, kind: int, info: TopicInfo) -> list[HostEvent] | None:
        """Add an announcement on reserved id `kind`; return the changes, None beyond the limit."""
        key = key_of(kind, info)
        known = self._endpoints.get(key)
        if known is not None and known.is_current and (known.kind, known.info) == (kind, info):
            return []
        if known is None and len(self._endpoints) >= self._max_endpoints:
            return None
        events: list[HostEvent] = []
        if known is not None and (known.kind, known.info) == (kind, info):
            known.is_current = True
        else:
            if known is not None:
                events += self._remove(key)
            self._endpoints[key] = _Endpoint(kind, info, self._largest_payload(info))
            self._limits = None
            if kind in _ROLES:
                events.append(TopicAnnounced(_ROLES[kind], info))
            if kind not in _ROLES or (known is not None and known.kind not in _ROLES):
                events += self._pair_services()
        if key.sends:
            self.senders.add(key.topic_id)
        else:
            self.send_limits[key.topic_id] = info.buffer_size
        return events

    def withdraw_all_but(self, keys: Iterable[EndpointKey]) -> list[HostEvent]:
        """Remove all endpoints except those with the given keys."""
        events: list[HostEvent] = []
        for key in sorted(self.keys() - set(keys)):
            events += self._remove(key)
        return events + self._pair_services()

    def mark_stale(self) -> None:
        """Send nothing to an endpoint until it is announced again: the device has been reset."""
        for endpoint in self._endpoints.values():
            endpoint.is_current = False
        self.send_limits.clear()

    def _remove(self, key: EndpointKey) -> list[HostEvent]:
        endpoint = self._endpoints.pop(key)
        self._limits = None
        if key.sends:
            self.senders.discard(key.topic_id)
        else:
            self.send_limits.pop(key.topic_id, None)
        if endpoint.kind in _ROLES:
            return [TopicWithdrawn(_ROLES[endpoint.kind], endpoint.info)]
        return []

    def _largest_payload(self, info: TopicInfo) -> int:
        """Return the size of a topic's largest message."""
        if info.buffer_size >= MAX_PAYLOAD_BYTES and self._fixed_size is not None:
            # A library that streams has no buffer size to announce.
            size = self._fixed_size(info)
            if size is not None:
                return size
        return info.buffer_size

    def _make_limits(self) -> PayloadLimits:
        """Return the limits of payloads from the announcements; without any, nothing is refused.

        Control packets may fill the board's buffer.
        """
        sent = {key.topic_id: each for key, each in self._endpoints.items() if key.sends}
        possible = CONTROL_LIMITS | {topic_id: each.largest_payload for topic_id, each in sent.items()}
        if not sent:
            return PayloadLimits(possible)
        largest = max(each.info.buffer_size for each in sent.values())
        refused_above: dict[int | None, int] = {
            topic_id: max(size, largest) if topic_id in CONTROL_LIMITS else size
            for topic_id, size in possible.items()
        }
        refused_above[None] = largest
        return PayloadLimits(possible, refused_above)

    def _pair_services(self) -> list[HostEvent]:
        """Pair the requests and responses of each service in the order of their ids; return the changes."""
        pairs: dict[tuple[ServiceRole, int, int], ServiceAnnounced] = {}
        for role, kinds in SERVICE_KINDS.items():
            found: dict[tuple[str, str], tuple[list[TopicInfo], list[TopicInfo]]] = {}
            for _, endpoint in sorted(self._endpoints.items()):
                if endpoint.kind in kinds:
                    service = endpoint.info.topic_name, endpoint.info.message_type
                    found.setdefault(service, ([], []))[kinds.index(endpoint.kind)].append(endpoint.info)
            for (name, service_type), (requests, responses) in found.items():
                if len(requests) == len(responses):
                    for request, response in zip(requests, responses, strict=True):
                        pairs[role, request.topic_id, response.topic_id] = ServiceAnnounced(
                            role, name, service_type, request, response
                        )
        gone = [service for key, service in self._services.items() if pairs.get(key) != service]
        names = {(service.role, service.name) for service in gone}
        # Unchanged endpoints of the same name come first, so that the server of the name continues with them.
        events: list[HostEvent] = [
            pair
            for key, pair in pairs.items()
            if self._services.get(key) == pair and (pair.role, pair.name) in names
        ]
        events += [
            ServiceWithdrawn(each.role, each.name, each.type, each.request, each.response) for each in gone
        ]
        events += [pair for key, pair in pairs.items() if self._services.get(key) != pair]
        self._services = pairs
        return events
