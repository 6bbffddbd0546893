"""The announcements of a client after a request for its topics."""

from __future__ import annotations

from collections import Counter

from rostether.conformance.case import CaseList
from rostether.conformance.checked_client import CheckedClient
from rostether.conformance.received_frame import Announcement, Deviation, is_time_request
from rostether.errors import DefinitionError
from rostether.mechanisms.text import counted
from rostether.msgdef.registry import Registry
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.packets import MAX_BUFFER_BYTES, TIME_BYTES, TopicInfo

# The smallest useful buffer: a time, the longest packet that every client receives.
MIN_BUFFER_BYTES = TIME_BYTES

case = CaseList()


@case("announce-layout")
async def check_layout(client: CheckedClient) -> None:
    """Each announcement is a TopicInfo without bytes before or after it."""
    for each in client.announcements:
        if each.info is None:
            size = counted(len(each.payload), "byte")
            raise Deviation(f"id {each.kind} has {size}: {each.payload[:32].hex(' ')}")


@case("announce-ids")
async def check_ids(client: CheckedClient) -> None:
    """Topic ids are at least 100, and none is announced twice."""
    counts = Counter(info.topic_id for info in _infos(client))
    low = [each for each in counts if each < ids.FIRST_USER_ID]
    twice = [each for each, count in counts.items() if count > 1]
    if low or twice:
        raise Deviation(f"topic id {(low or twice)[0]} is {'reserved' if low else 'announced twice'}")


@case("announce-names")
async def check_names(client: CheckedClient) -> None:
    """Names and types are valid: letters, digits, _ and /, and package/Type."""
    for info in _infos(client):
        fault = info.fault() if info.topic_id >= ids.FIRST_USER_ID else None
        if fault is not None and "buffer size" not in fault:
            raise Deviation(f"{info.topic_name!r} [{info.message_type}]: {fault}")


@case("announce-md5sums")
async def check_md5sums(client: CheckedClient) -> None:
    """The md5sum is that of the message. Of a service, ids 2 and 5 are the response, 3 and 4 the request."""
    registry = Registry()
    for each in client.announcements:
        wanted = _md5sum(registry, each)
        if each.info is not None and wanted is not None and each.info.md5sum != wanted:
            raise Deviation(f"{each.name} [{each.info.message_type}] has {each.info.md5sum}, not {wanted}")


@case("announce-buffers")
async def check_buffers(client: CheckedClient) -> None:
    """Buffer sizes are 8 bytes to 1 MiB."""
    for info in _infos(client):
        if not MIN_BUFFER_BYTES <= info.buffer_size <= MAX_BUFFER_BYTES:
            raise Deviation(f"{info.topic_name} announces a buffer of {counted(info.buffer_size, 'byte')}")


@case("announce-services")
async def check_services(client: CheckedClient) -> None:
    """Each service is announced twice with the same type: on 2 and 3, or on 4 and 5."""
    announced = {(each.kind, each.name, each.info.message_type) for each in client.announcements if each.info}
    for kind, name, service_type in announced:
        if kind >= ids.SERVICE_SERVER_RESPONSE and (kind ^ 1, name, service_type) not in announced:
            raise Deviation(f"{name} [{service_type}] is announced on {kind}, but not on {kind ^ 1}")


@case("announce-again")
async def check_again(client: CheckedClient) -> None:
    """A second request is answered with the same announcements."""
    again = set(await client.configure())
    missing = [each for each in client.announcements if each not in again]
    if missing:
        raise Deviation(f"{len(missing)} of {len(client.announcements)} announcements differ or are missing")


@case("announce-time")
async def check_time_request(client: CheckedClient) -> None:
    """A topic request is answered with a time request: id 10, 8 or 0 bytes."""
    client.send(ids.TOPIC_REQUEST)
    frame = await client.expect(lambda each: each.topic_id == ids.TIME, "a time request")
    client.require_configuration()
    if not is_time_request(frame):
        raise Deviation(f"the time request has {counted(len(frame.payload), 'byte')}")


@case("announce-split")
async def check_split(client: CheckedClient) -> None:
    """A topic request is answered if its bytes arrive one by one."""
    client.require_configuration()
    await client.send_slowly(encode_frame(ids.TOPIC_REQUEST, b""))
    await client.expect(lambda each: each.topic_id in ids.ANNOUNCEMENTS, "an announcement")


def _infos(client: CheckedClient) -> list[TopicInfo]:
    return [each.info for each in client.announcements if each.info is not None]


def _md5sum(registry: Registry, each: Announcement) -> str | None:
    """Return the md5sum that an announcement must have; None for a type that is not known here."""
    if each.info is None:
        return None
    try:
        if each.kind in (ids.PUBLISHER, ids.SUBSCRIBER):
            return registry.message_type(each.info.message_type).md5sum
        service = registry.service_type(each.info.message_type)
    except DefinitionError:
        return None
    is_response = each.kind in (ids.SERVICE_SERVER_RESPONSE, ids.SERVICE_CLIENT_RESPONSE)
    return (service.response if is_response else service.request).md5sum
