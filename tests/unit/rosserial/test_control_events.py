from __future__ import annotations

import pytest

from rostether.rosserial import topic_id as ids
from rostether.rosserial.control_events import control_event
from rostether.rosserial.events import DiscardReason, FrameDiscarded, LogReceived, ParameterRequested
from rostether.rosserial.packets import Log, LogLevel


def test_log_and_parameter_request() -> None:
    assert control_event(ids.LOG, Log(LogLevel.DEBUG, "x").encode()) == LogReceived(LogLevel.DEBUG, "x")
    assert control_event(ids.PARAMETER, b"\x02\0\0\0~a") == ParameterRequested("~a")


@pytest.mark.parametrize("topic_id", [ids.LOG, ids.PARAMETER])
def test_wrong_layout(topic_id: int) -> None:
    assert control_event(topic_id, b"\xff") == FrameDiscarded(DiscardReason.PACKET, b"\xff", topic_id)


@pytest.mark.parametrize("topic_id", [8, 9, ids.TX_STOP, 12, 99])
def test_ids_without_a_meaning(topic_id: int) -> None:
    assert control_event(topic_id, b"x") == FrameDiscarded(DiscardReason.UNEXPECTED, b"x")
