"""The frames of a recorded line, in order, as text."""

from __future__ import annotations

from collections.abc import Iterator

from msgspec import Struct

from rostether.mechanisms.text import escape_line
from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import FrameDiscarded
from rostether.rosserial.frame_decoder import Decoded, FrameDecoder, Frames
from rostether.rosserial.packets import Log, ParameterRequest, TopicInfo

# A decoder groups the frames of one chunk by topic. A frame has at least 8 bytes: at most one ends in these.
_STEP_BYTES = 7

_KINDS = (
    "publisher",
    "subscriber",
    "service server response",
    "service server request",
    "service client request",
    "service client response",
)


class LineEntry(Struct, frozen=True):
    """A frame, described by `what`, with its payload as `data`; or bytes outside frames.

    For those, `data` has the bytes, `topic_id` is None, and `fault` is the reason.
    """

    time_s: float
    from_device: bool
    topic_id: int | None
    what: str
    data: bytes
    fault: str = ""


class LineLog:
    """Reads both directions of one link; `version` is the protocol version."""

    def __init__(self, version: int = 2) -> None:
        self._decoders = {True: FrameDecoder(version), False: FrameDecoder(version)}
        self._topics: dict[int, str] = {}

    def feed(self, time_s: float, from_device: bool, data: bytes) -> Iterator[LineEntry]:
        """Handle bytes of one side, and yield the entries that they complete."""
        decoder = self._decoders[from_device]
        while (due_s := decoder.get_timer()) is not None and due_s <= time_s:
            yield from self._entries(due_s, from_device, decoder.handle_timer(due_s))
        decoded: list[Decoded] = []
        for at in range(0, len(data), _STEP_BYTES):
            decoded += decoder.feed(data[at : at + _STEP_BYTES], time_s)
        if not from_device:
            # A host writes complete frames, and may change the version while it searches for the board's.
            decoded += decoder.abandon(time_s)
        yield from self._entries(time_s, from_device, _joined(decoded))

    def finish(self, time_s: float) -> Iterator[LineEntry]:
        """Yield the unfinished frames."""
        for from_device, decoder in self._decoders.items():
            yield from self._entries(time_s, from_device, decoder.abandon(time_s))

    def _entries(self, time_s: float, from_device: bool, decoded: list[Decoded]) -> Iterator[LineEntry]:
        for each in decoded:
            if isinstance(each, FrameDiscarded):
                yield LineEntry(time_s, from_device, None, "", each.data, each.reason.value)
                continue
            for payload in each.payloads:
                what = self._describe(each.topic_id, from_device, payload)
                yield LineEntry(time_s, from_device, each.topic_id, what, payload)

    def _describe(self, topic_id: int, from_device: bool, payload: bytes) -> str:
        if not from_device and topic_id == ids.TOPIC_REQUEST:
            return "requests the topics"
        if from_device and topic_id in ids.ANNOUNCEMENTS:
            return self._announcement(topic_id, payload)
        if topic_id == ids.TIME:
            return "requests the time" if from_device else "answers with the time"
        if topic_id == ids.TX_STOP:
            return "requests a stop"
        if topic_id == ids.LOG:
            log = Log.decode(payload)
            return f"logs {log.level.name} {log.text!r}" if log is not None else "an invalid log line"
        if topic_id == ids.PARAMETER:
            if not from_device:
                return "answers with a parameter"
            asked = ParameterRequest.decode(payload)
            return f"requests parameter {asked.name}" if asked is not None else "an invalid request"
        return self._topics.get(topic_id, "a topic that was not announced")

    def _announcement(self, topic_id: int, payload: bytes) -> str:
        info = TopicInfo.read(payload)
        if info is None:
            return "an invalid announcement"
        if info.fault() is None:
            self._topics[info.topic_id] = info.topic_name
        return (
            f"{_KINDS[topic_id]} {info.topic_name!r} "
            f"[{escape_line(info.message_type)}] id {info.topic_id}, {info.buffer_size} bytes, "
            f"md5 {escape_line(info.md5sum)}"
        )


def version_of(device_bytes: bytes) -> int:
    """Return the protocol version that reads more frames in a device's first bytes; 2 for equal numbers."""

    def count(version: int) -> int:
        decoder = FrameDecoder(version)
        decoded = decoder.feed(device_bytes, 0.0) + decoder.abandon(0.0)
        return sum(len(each.payloads) for each in decoded if isinstance(each, Frames))

    return 1 if count(1) > count(2) else 2


def _joined(decoded: list[Decoded]) -> list[Decoded]:
    """Join consecutive entries of bytes outside frames."""
    joined: list[Decoded] = []
    for each in decoded:
        last = joined[-1] if joined else None
        if (
            isinstance(each, FrameDiscarded)
            and isinstance(last, FrameDiscarded)
            and last.reason is each.reason
        ):
            joined[-1] = FrameDiscarded(each.reason, last.data + each.data)
        else:
            joined.append(each)
    return joined
