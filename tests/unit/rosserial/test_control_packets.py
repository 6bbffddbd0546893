from __future__ import annotations

import pytest

from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import (
    DiscardReason,
    FrameDiscarded,
    HostEvent,
    LogReceived,
    ParameterRequested,
)
from rostether.rosserial.packets import Log, LogLevel
from unit.rosserial.decoding import frame
from unit.rosserial.host_link_boards import settled_link


def events_of(topic_id: int, payload: bytes) -> list[HostEvent]:
    link, now_s = settled_link()
    return link.receive_data(frame(topic_id, payload), now_s)


def test_log_and_parameter_request() -> None:
    assert events_of(ids.LOG, Log(LogLevel.DEBUG, "x").encode()) == [LogReceived(LogLevel.DEBUG, "x")]
    assert events_of(ids.PARAMETER, b"\x02\0\0\0~a") == [ParameterRequested("~a")]


@pytest.mark.parametrize("topic_id", [ids.LOG, ids.PARAMETER])
def test_wrong_layout(topic_id: int) -> None:
    assert events_of(topic_id, b"\xff") == [FrameDiscarded(DiscardReason.PACKET, b"\xff", topic_id)]


@pytest.mark.parametrize("topic_id", [8, 9, ids.TX_STOP, 12, 99])
def test_ids_without_a_meaning(topic_id: int) -> None:
    assert events_of(topic_id, b"x") == [FrameDiscarded(DiscardReason.UNEXPECTED, b"x")]
