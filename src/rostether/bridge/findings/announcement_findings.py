"""Invalid control packets of a board: its RAM was overwritten, or its sketch is wrong."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator

from rostether.bridge.findings.finding import Code, Finding, error, split_step
from rostether.bridge.findings.noise import show
from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import AnnouncementRefused, DiscardReason, FrameDiscarded
from rostether.rosserial.packets import TopicInfo

# One damaged frame in 256 passes its checksum: a single case may be line noise.
MIN_COUNT = 2

# More than any board has room for; limits the memory for a device that announces new names all the time.
MAX_KEPT = 64


_PACKETS: dict[int | None, str] = {
    ids.TIME: "time requests",
    ids.LOG: "log lines",
    ids.PARAMETER: "parameter requests",
}


class AnnouncementFindings:
    """The invalid announcements of one connection."""

    def __init__(self) -> None:
        self._garbled: OrderedDict[tuple[int | None, bytes], int] = OrderedDict()
        self._garbled_count = 0
        self._refused: OrderedDict[tuple[str, str], AnnouncementRefused] = OrderedDict()

    def discarded(self, event: FrameDiscarded) -> None:
        """Record a payload with a correct checksum and invalid content."""
        payload = event.data
        if event.reason is DiscardReason.REFUSED:
            info = TopicInfo.read(payload)
            if info is None or not is_overwritten(info):
                return
            self._garbled_count += 1
        elif event.reason is not DiscardReason.PACKET:
            return
        packet = event.topic_id, payload
        self._garbled[packet] = self._garbled.get(packet, 0) + 1
        # Noise does not repeat itself.
        if event.reason is DiscardReason.PACKET and self._garbled[packet] >= MIN_COUNT:
            self._garbled_count += 1
        while len(self._garbled) > MAX_KEPT:
            self._garbled.popitem(last=False)

    def refused(self, event: AnnouncementRefused) -> None:
        """Record an announcement that was readable but refused."""
        if len(self._refused) < MAX_KEPT:
            self._refused[event.topic_name, event.message_type] = event

    def find(self) -> Iterator[Finding]:
        """Yield the findings."""
        if self._garbled_count >= MIN_COUNT:
            topic_id, payload = max(self._garbled, key=lambda each: self._garbled[each])
            what = _PACKETS.get(topic_id, "names or md5sums in the announcements")
            yield error(
                Code.RAM_OVERFLOW,
                f"{what} are damaged inside the board ({_describe(payload)}), but the checksums are right: "
                "its RAM is overwritten",
                "use fewer topics and smaller buffers (ros::NodeHandle_<ArduinoHardware, 6, 6, 150, 150>), "
                "keep texts in flash with F(), and do not publish strings from local buffers that no longer "
                "exist",
            )
        for event in self._refused.values():
            if not _has_damage(event.topic_name + event.message_type) and "md5sum ''" not in event.reason:
                name = event.topic_name or "a topic without a name"
                reason, step = split_step(event.reason, "correct it in the sketch")
                seen = f"{name} [{event.message_type}] is not bridged: {reason}"
                yield error(Code.NOT_BRIDGED, seen, step, event.topic_name, is_reported=True)


def is_overwritten(info: TopicInfo) -> bool:
    """Return whether an announcement in a valid frame has texts that no sketch contains."""
    texts = (info.topic_name, info.message_type, info.md5sum)
    return any(map(_has_damage, texts)) or not info.md5sum or not info.message_type


def _has_damage(text: str) -> bool:
    return not (text.isascii() and text.isprintable())


def _describe(payload: bytes) -> str:
    info = TopicInfo.read(payload)
    if info is None:
        return show(payload) if payload else "empty"
    return f"topic {info.topic_name!r}, type {info.message_type!r}, md5sum {info.md5sum!r}"[:200]
