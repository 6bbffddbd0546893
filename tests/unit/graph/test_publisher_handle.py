from __future__ import annotations

from collections.abc import Sequence

import pytest

from rostether.errors import TypeMismatchError
from rostether.graph.publisher_handle import PublisherHandle, check_same_type
from rostether.msgdef.interface import ANY_MESSAGE, MessageType

INT = MessageType("std_msgs/Int32", "a" * 32)
TEXT = MessageType("std_msgs/String", "b" * 32)


class _Publication:
    topic = "/chatter"
    type = INT
    subscriber_count = 2
    dropped_count = 3

    def __init__(self) -> None:
        self.handle_count = 0
        self.published: list[bytes] = []
        self.waited_s = 0.0

    def publish(self, payloads: Sequence[bytes]) -> bool:
        self.published += payloads
        return False

    async def drained(self, timeout_s: float) -> None:
        self.waited_s = timeout_s


async def test_the_last_handle_ends_the_publication() -> None:
    publication = _Publication()
    ended: list[_Publication] = []

    async def end(publication: _Publication) -> None:
        ended.append(publication)

    first, second = (PublisherHandle(publication, end) for _ in range(2))
    assert (first.topic, first.type, first.subscriber_count, first.dropped_count) == ("/chatter", INT, 2, 3)
    assert not first.publish_raw([b"1"])
    await first.drained(0.5)
    assert publication.waited_s == 0.5

    await first.close()
    await first.close()
    # A closed handle publishes nothing and requests no pause.
    assert first.publish_raw([b"2"])
    assert publication.published == [b"1"]
    assert ended == []

    await second.close()
    assert ended == [publication]


def test_handles_share_one_type() -> None:
    check_same_type("/chatter", INT, INT)
    check_same_type("/chatter", INT, ANY_MESSAGE)
    with pytest.raises(TypeMismatchError, match="publishes /chatter as std_msgs/Int32, not as"):
        check_same_type("/chatter", INT, TEXT)
