"""The endpoints of a device, numbered and announced in the order of the established library.

The ids of subscribers start at 100, those of publishers at 100 + the maximum number of subscribers. A service
uses one id of each kind. If the device serves it, it publishes the response and subscribes to the request. If
the device calls it, it publishes the request and subscribes to the response.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rostether.errors import LocalProtocolError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.packets import TopicInfo


class ServiceIds(NamedTuple):
    """The two topic ids of one service."""

    request_id: int
    response_id: int


class DeviceEndpoints:
    """Declared endpoints by direction; buffer sizes in bytes are announced with each.

    Declaring one raises LocalProtocolError if there is no room for it, or if a host would reject it.
    """

    def __init__(
        self, *, max_publishers: int, max_subscribers: int, input_buffer_bytes: int, output_buffer_bytes: int
    ) -> None:
        self._max_publishers = max_publishers
        self._max_subscribers = max_subscribers
        self._input_buffer_bytes = input_buffer_bytes
        self._output_buffer_bytes = output_buffer_bytes
        self._senders: dict[int, tuple[int, TopicInfo]] = {}
        self._listeners: dict[int, tuple[int, TopicInfo]] = {}

    def add_publisher(self, topic: str, message_type: str, md5sum: str) -> int:
        """Declare a topic that the device publishes; return its id."""
        return self._add(ids.PUBLISHER, topic, message_type, md5sum)

    def add_subscriber(self, topic: str, message_type: str, md5sum: str) -> int:
        """Declare a topic that the device subscribes to; return its id."""
        return self._add(ids.SUBSCRIBER, topic, message_type, md5sum)

    def add_service_server(
        self, service: str, service_type: str, request_md5sum: str, response_md5sum: str
    ) -> ServiceIds:
        """Declare a service that the device serves."""
        self._require_room_for_both()
        response_id = self._add(ids.SERVICE_SERVER_RESPONSE, service, service_type, response_md5sum)
        request_id = self._add(ids.SERVICE_SERVER_REQUEST, service, service_type, request_md5sum)
        return ServiceIds(request_id, response_id)

    def add_service_client(
        self, service: str, service_type: str, request_md5sum: str, response_md5sum: str
    ) -> ServiceIds:
        """Declare a service that the device calls."""
        self._require_room_for_both()
        request_id = self._add(ids.SERVICE_CLIENT_REQUEST, service, service_type, request_md5sum)
        response_id = self._add(ids.SERVICE_CLIENT_RESPONSE, service, service_type, response_md5sum)
        return ServiceIds(request_id, response_id)

    def is_sender(self, topic_id: int) -> bool:
        """Return whether the device sends on this id."""
        return topic_id in self._senders

    def is_listener(self, topic_id: int) -> bool:
        """Return whether the device receives on this id."""
        return topic_id in self._listeners

    def announcements(self) -> Iterator[tuple[int, TopicInfo]]:
        """Yield (reserved id, announcement), publishers first."""
        yield from self._senders.values()
        yield from self._listeners.values()

    def _add(self, kind: int, name: str, message_type: str, md5sum: str) -> int:
        if kind in ids.DEVICE_SENDS_ON:
            declared, limit, noun = self._senders, self._max_publishers, "publishers"
            first_id, buffer_bytes = ids.FIRST_USER_ID + self._max_subscribers, self._output_buffer_bytes
        else:
            declared, limit, noun = self._listeners, self._max_subscribers, "subscribers"
            first_id, buffer_bytes = ids.FIRST_USER_ID, self._input_buffer_bytes
        if len(declared) >= limit:
            raise LocalProtocolError(
                f"no room for {name}: all {limit} {noun} are declared; declare fewer, or raise max_{noun}"
            )
        info = TopicInfo(first_id + len(declared), name, message_type, md5sum, buffer_bytes)
        if TopicInfo.decode(info.encode()) != info:
            raise LocalProtocolError(
                f"a host would reject {name!r} [{message_type}] with md5sum {md5sum!r}; give a valid name, "
                "package/Type and its md5sum"
            )
        declared[info.topic_id] = kind, info
        return info.topic_id

    def _require_room_for_both(self) -> None:
        if len(self._senders) >= self._max_publishers or len(self._listeners) >= self._max_subscribers:
            raise LocalProtocolError(
                "no room for a service, which needs one publisher and one subscriber; declare fewer, "
                "or raise max_publishers and max_subscribers"
            )
