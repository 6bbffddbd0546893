"""A decoder for tests that shares nothing with the package, and ways to feed the real one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rostether.errors import LocalProtocolError
from rostether.rosserial.events import FrameDiscarded
from rostether.rosserial.frame_decoder import Decoded, FrameDecoder, Frames
from rostether.rosserial.host_link import HostLink


def frame(topic_id: int, payload: bytes, version: int = 2) -> bytes:
    """Return one frame, written without the package."""
    size, number = len(payload).to_bytes(2, "little"), topic_id.to_bytes(2, "little")
    if version == 1:
        return b"\xff\xff" + number + size + payload + bytes([255 - sum(number + size + payload) % 256])
    length_check = bytes([255 - sum(size) % 256])
    return b"\xff\xfe" + size + length_check + number + payload + bytes([255 - sum(number + payload) % 256])


def plain_decode(data: bytes, version: int = 2) -> Iterator[tuple[int, bytes]]:
    """Yield (topic id, payload) of every valid frame; look for a frame at each byte."""
    position = 0
    while position < len(data):
        found = _frame_at(data, position, version)
        if found is None:
            position += 1
        else:
            topic_id, payload, position = found
            yield topic_id, payload


def _frame_at(data: bytes, position: int, version: int) -> tuple[int, bytes, int] | None:
    if version == 1:
        head = data[position : position + 6]
        if len(head) < 6 or head[:2] != b"\xff\xff":
            return None
        topic_id, size, start = head[2] + 256 * head[3], head[4] + 256 * head[5], position + 6
        counted = position + 2
    else:
        head = data[position : position + 7]
        if len(head) < 7 or head[:2] != b"\xff\xfe" or (head[2] + head[3] + head[4]) % 256 != 255:
            return None
        topic_id, size, start = head[5] + 256 * head[6], head[2] + 256 * head[3], position + 7
        counted = position + 5
    end = start + size + 1
    if end > len(data) or sum(data[counted:end]) % 256 != 255:
        return None
    return topic_id, data[start : end - 1], end


def by_topic(decoded: Iterable[Decoded]) -> dict[int, list[bytes]]:
    """Return the decoded payloads by topic id."""
    payloads: dict[int, list[bytes]] = {}
    for item in decoded:
        if isinstance(item, Frames):
            payloads.setdefault(item.topic_id, []).extend(item.payloads)
    return payloads


def discards(decoded: Iterable[Decoded]) -> list[FrameDiscarded]:
    return [item for item in decoded if isinstance(item, FrameDiscarded)]


def joined_discards(decoded: Iterable[Decoded]) -> list[tuple[str, bytes]]:
    """Return (reason, bytes) of discarded bytes; join the parts that were in different chunks."""
    joined: list[tuple[str, bytes]] = []
    for item in discards(decoded):
        if joined and (item.reason.name in ("NOISE", joined[-1][0])) and joined[-1][0] != "UNFINISHED":
            joined[-1] = joined[-1][0], joined[-1][1] + item.data
        else:
            joined.append((item.reason.name, item.data))
    return joined


def feed_whole(decoder: FrameDecoder, data: bytes) -> list[Decoded]:
    return decoder.feed(data, 0.0)


def feed_byte_by_byte(decoder: FrameDecoder, data: bytes) -> list[Decoded]:
    return [
        item for position in range(len(data)) for item in decoder.feed(data[position : position + 1], 0.0)
    ]


def can_send(link: HostLink, topic_id: int) -> bool:
    """Return whether the device accepts messages on this id now."""
    try:
        link.encode_messages(topic_id, ())
    except LocalProtocolError:
        return False
    return True
