"""Boards and lines that the host link's tests negotiate with."""

from __future__ import annotations

from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_link import DeviceLink, DeviceLinkConfig
from rostether.rosserial.events import (
    HostEvent,
)
from rostether.rosserial.host_link import HostLink
from rostether.rosserial.packets import TopicInfo
from unit.rosserial.decoding import frame
from unit.rosserial.sessions import (
    EMPTY,
    EMPTY_MD5,
    STRING,
    STRING_MD5,
    Line,
)

REQUEST = frame(ids.TOPIC_REQUEST, b"")
CHATTER = TopicInfo(125, "chatter", STRING, STRING_MD5, 280)
LED = TopicInfo(100, "led", EMPTY, EMPTY_MD5, 150)
TIME = frame(ids.TIME, bytes(8))
BURST = TIME + frame(ids.PUBLISHER, CHATTER.encode()) + frame(ids.SUBSCRIBER, LED.encode())


def line_to(device: DeviceLink, **options: object) -> Line:
    line = Line(HostLink(), device, **options)  # type: ignore[arg-type]
    line.start()
    return line


def small_device(version: int = 2) -> tuple[DeviceLink, int, int]:
    device = DeviceLink(DeviceLinkConfig(version=version))
    return (
        device,
        device.add_publisher("chatter", STRING, STRING_MD5),
        device.add_subscriber("led", EMPTY, EMPTY_MD5),
    )


def settled_link() -> tuple[HostLink, float]:
    """Return a link that has settled on CHATTER and LED, and the time."""
    link, now_s, _ = settle_on(BURST)
    return link, now_s


def settle_on(burst: bytes) -> tuple[HostLink, float, list[HostEvent]]:
    """Return a new link that has settled on what is announced here, the time, and what was reported."""
    link = HostLink()
    link.start(0.0)
    now_s, events = run_to_settled(link, 0.0, burst)
    return link, now_s, events


def run_to_settled(link: HostLink, now_s: float, burst: bytes) -> tuple[float, list[HostEvent]]:
    """Answer each request with this burst until the link is settled; return the time and the events."""
    events: list[HostEvent] = []
    while not link.is_settled:
        if REQUEST in link.data_to_send():
            events += link.receive_data(burst, now_s + 0.01)
        due_s = link.get_timer()
        assert due_s is not None
        now_s = due_s
        events += link.handle_timer(now_s)
    link.data_to_send()
    return now_s, events


def only(events: list[HostEvent], *kinds: type) -> list[HostEvent]:
    return [event for event in events if isinstance(event, kinds)]
