"""Converts control packets that need no state into events."""

from __future__ import annotations

from collections.abc import Callable

from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import (
    DiscardReason,
    FrameDiscarded,
    HostEvent,
    LogReceived,
    ParameterRequested,
)
from rostether.rosserial.packets import Log, ParameterRequest


def control_event(topic_id: int, payload: bytes) -> HostEvent:
    """Return the event of one frame; FrameDiscarded if its id or its layout is not valid."""
    reader = _READERS.get(topic_id)
    if reader is None:
        return FrameDiscarded(DiscardReason.UNEXPECTED, payload)
    return reader(payload) or FrameDiscarded(DiscardReason.PACKET, payload, topic_id)


def _log(payload: bytes) -> LogReceived | None:
    log = Log.decode(payload)
    return log and LogReceived(*log)


def _parameter_request(payload: bytes) -> ParameterRequested | None:
    request = ParameterRequest.decode(payload)
    return request and ParameterRequested(*request)


_READERS: dict[int, Callable[[bytes], HostEvent | None]] = {
    ids.LOG: _log,
    ids.PARAMETER: _parameter_request,
}
