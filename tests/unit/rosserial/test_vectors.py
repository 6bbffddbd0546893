"""Both links read every recorded session, and report the same contents as an independent decoder."""

from __future__ import annotations

import struct
from collections import Counter

import pytest

from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_link import DeviceLink, DeviceLinkConfig
from rostether.rosserial.events import (
    DeviceEvent,
    DeviceSilent,
    DiscardReason,
    FrameDiscarded,
    HostEvent,
    LogReceived,
    MessagesReceived,
    ParameterReceived,
    ParameterRequested,
    ServiceAnnounced,
    ServiceRole,
    StopReceived,
    TimeAnswered,
    TimeRequested,
    TopicAnnounced,
    TopicRole,
    TopicsRequested,
    UnknownTopicId,
)
from rostether.rosserial.host_link import HostLink
from rostether.rosserial.packets import TopicInfo
from rostether.rostime import Time
from unit.rosserial.decoding import plain_decode
from vectors.captures import Capture, frame_counts, load, names

COUNTS = frame_counts()
DAMAGE = {DiscardReason.LENGTH_CHECKSUM, DiscardReason.PAYLOAD_CHECKSUM, DiscardReason.UNFINISHED}
LOST_ANNOUNCEMENTS = {"damaged_announce": {100}}
"""The topic ids whose announcement the host never received in a recording, because it was damaged."""

KINDS = {
    "publisher": ids.PUBLISHER,
    "subscriber": ids.SUBSCRIBER,
    "service server, response": ids.SERVICE_SERVER_RESPONSE,
    "service server, request": ids.SERVICE_SERVER_REQUEST,
    "service client, request": ids.SERVICE_CLIENT_REQUEST,
    "service client, response": ids.SERVICE_CLIENT_RESPONSE,
}


def replay_to_host(capture: Capture) -> tuple[HostLink, list[HostEvent]]:
    """Feed the received bytes to a host, and call its timers when they are due; its output is discarded."""
    link = HostLink()
    events: list[HostEvent] = []
    link.start(0.0)
    for chunk in capture.of_device():
        while (due_s := link.get_timer()) is not None and due_s <= chunk.time_s:
            events += link.handle_timer(due_s)
        events += link.receive_data(chunk.data, chunk.time_s)
        link.data_to_send()
    return link, events


def replay_to_device(capture: Capture) -> tuple[DeviceLink, list[DeviceEvent]]:
    """Feed the received bytes to a device that declares the endpoints of the capture."""
    link = DeviceLink(DeviceLinkConfig(version=capture.version))
    for _, topic in sorted(capture.topics.items()):
        if topic.kind == "publisher":
            link.add_publisher(topic.name, topic.type, topic.md5sum)
        elif topic.kind == "subscriber":
            link.add_subscriber(topic.name, topic.type, topic.md5sum)
        elif topic.kind.endswith("response"):
            request = next(
                other.md5sum
                for other in capture.topics.values()
                if other.name == topic.name and other.kind == topic.kind.replace("response", "request")
            )
            add = link.add_service_server if "server" in topic.kind else link.add_service_client
            add(topic.name, topic.type, request, topic.md5sum)
    events: list[DeviceEvent] = []
    link.start(0.0)
    for chunk in capture.of_host():
        while (due_s := link.get_timer()) is not None and due_s <= chunk.time_s:
            events += link.handle_timer(due_s)
        events += link.receive_data(chunk.data, chunk.time_s)
        link.data_to_send()
    return link, events


def received(events: list[HostEvent] | list[DeviceEvent]) -> dict[int, list[bytes]]:
    payloads: dict[int, list[bytes]] = {}
    for event in events:
        if isinstance(event, MessagesReceived):
            payloads.setdefault(event.topic_id, []).extend(event.payloads)
    return payloads


def frames_of(capture: Capture, *, from_device: bool) -> list[tuple[int, bytes]]:
    """Decode one side. Each write of the host contains only whole frames, and is decoded separately."""
    if from_device:
        return list(plain_decode(b"".join(chunk.data for chunk in capture.of_device()), capture.version))
    return [frame for chunk in capture.of_host() for frame in plain_decode(chunk.data, capture.version)]


def messages(frames: list[tuple[int, bytes]]) -> dict[int, list[bytes]]:
    payloads: dict[int, list[bytes]] = {}
    for topic_id, payload in frames:
        if topic_id >= ids.FIRST_USER_ID:
            payloads.setdefault(topic_id, []).append(payload)
    return payloads


def test_every_capture_is_counted() -> None:
    assert set(names()) == set(COUNTS)
    assert len(names()) == 24


@pytest.mark.parametrize("name", names())
class TestHostLink:
    def test_frames_and_damage(self, name: str) -> None:
        link, events = replay_to_host(load(name))
        frames, _, damaged = COUNTS[name]
        assert link.statistics.frames_received == frames
        counted = Counter(event.reason for event in events if isinstance(event, FrameDiscarded))
        assert sum(counted[reason] for reason in DAMAGE) == damaged
        assert counted[DiscardReason.PACKET] == 0

    def test_announced_endpoints(self, name: str) -> None:
        capture = load(name)
        _, events = replay_to_host(capture)
        found: dict[int, tuple[int, TopicInfo]] = {}
        for event in events:
            if isinstance(event, TopicAnnounced):
                is_publisher = event.role is TopicRole.PUBLISHER
                found[event.info.topic_id] = ids.PUBLISHER if is_publisher else ids.SUBSCRIBER, event.info
            elif isinstance(event, ServiceAnnounced):
                first = (
                    ids.SERVICE_SERVER_RESPONSE
                    if event.role is ServiceRole.SERVER
                    else ids.SERVICE_CLIENT_REQUEST
                )
                sends, listens = event.response, event.request
                if event.role is ServiceRole.CLIENT:
                    sends, listens = listens, sends
                found[sends.topic_id] = first, sends
                found[listens.topic_id] = first + 1, listens
        lost = LOST_ANNOUNCEMENTS.get(name, set())
        assert found == {
            topic_id: (
                KINDS[topic.kind],
                TopicInfo(topic_id, topic.name, topic.type, topic.md5sum, topic.buffer_size),
            )
            for topic_id, topic in capture.topics.items()
            if topic_id not in lost
        }

    def test_messages(self, name: str) -> None:
        capture = load(name)
        link, events = replay_to_host(capture)
        expected = messages(frames_of(capture, from_device=True))
        unannounced = link.statistics.unannounced_messages
        assert unannounced == (2 if name == "damaged" else 0)  # the publisher's announcement was damaged
        assert {topic_id: payloads[unannounced:] for topic_id, payloads in expected.items()} == received(
            events
        )

    def test_control_packets(self, name: str) -> None:
        frames = frames_of(load(name), from_device=True)
        _, events = replay_to_host(load(name))
        counts = Counter(topic_id for topic_id, _ in frames)
        assert sum(isinstance(event, TimeRequested) for event in events) == counts[ids.TIME]
        logs = [event for event in events if isinstance(event, LogReceived)]
        assert [bytes([log.level]) + log.text.encode() for log in logs] == [
            payload[:1] + payload[5:] for topic_id, payload in frames if topic_id == ids.LOG
        ]
        asked = [event.name.encode() for event in events if isinstance(event, ParameterRequested)]
        assert asked == [payload[4:] for topic_id, payload in frames if topic_id == ids.PARAMETER]

    def test_chunks_cut_elsewhere_give_the_same(self, name: str) -> None:
        capture = load(name)
        line = b"".join(chunk.data for chunk in capture.of_device())
        _, whole = replay_to_host(capture)
        link = HostLink()
        link.start(0.0)
        events: list[HostEvent] = []
        for start in range(0, len(line), 7):
            events += link.receive_data(line[start : start + 7], 0.0)
        assert received(events) == received(whole)

    def test_version(self, name: str) -> None:
        link, _ = replay_to_host(load(name))
        assert link.version == load(name).version


@pytest.mark.parametrize("name", names())
class TestDeviceLink:
    def test_frames(self, name: str) -> None:
        link, events = replay_to_device(load(name))
        assert link.statistics.frames_received == COUNTS[name][1]
        assert link.statistics.damaged_frames == 0
        assert not any(isinstance(event, UnknownTopicId) for event in events)

    def test_messages(self, name: str) -> None:
        _, events = replay_to_device(load(name))
        assert received(events) == messages(frames_of(load(name), from_device=False))

    def test_control_packets(self, name: str) -> None:
        frames = frames_of(load(name), from_device=False)
        _, events = replay_to_device(load(name))
        counts = Counter(topic_id for topic_id, _ in frames)
        assert sum(isinstance(event, TopicsRequested) for event in events) == counts[ids.TOPIC_REQUEST]
        assert sum(isinstance(event, StopReceived) for event in events) == counts[ids.TX_STOP]
        assert [event.time for event in events if isinstance(event, TimeAnswered)] == [
            Time(*struct.unpack("<II", payload)) for topic_id, payload in frames if topic_id == ids.TIME
        ]


@pytest.mark.parametrize("name", ["damaged", "damaged_announce"])
def test_only_whole_messages_of_a_damaged_line_are_believed(name: str) -> None:
    capture = load(name)
    _, events = replay_to_host(capture)
    clean = messages(list(plain_decode(b"".join(chunk.clean for chunk in capture.of_device()))))
    for topic_id, payloads in received(events).items():
        assert Counter(payloads) <= Counter(clean[topic_id])
        assert len(payloads) > len(clean[topic_id]) / 2


def test_parameters_as_the_device_got_them() -> None:
    capture = load("parameters")
    asked = [event.name for event in replay_to_host(capture)[1] if isinstance(event, ParameterRequested)]
    link = DeviceLink()
    link.start(0.0)
    for name in asked:
        if name != "/vec/missing":  # the established host does not answer
            link.request_parameter(name, 0.0, timeout_s=100.0)
    answers: list[DeviceEvent] = []
    for chunk in capture.of_host():
        answers += link.receive_data(chunk.data, chunk.time_s)
    assert [event for event in answers if isinstance(event, ParameterReceived)] == [
        ParameterReceived("/vec/int", (42,), (), ()),
        ParameterReceived("/vec/float", (), (2.5,), ()),
        ParameterReceived("/vec/name", (), (), ("left arm",)),
        ParameterReceived("/vec/gains", (), (1.5, -0.25, 10.0), ()),
        ParameterReceived("/vec/pins", (2, 3, 5, -7), (), ()),
        ParameterReceived("/vec/names", (), (), ("alpha", "beta")),
        ParameterReceived("/vec/flag", (1,), (), ()),
        ParameterReceived("/vec/gains", (), (1.5, -0.25, 10.0), ()),
    ]


def test_a_board_that_fell_silent_without_a_host_is_found_again() -> None:
    link, events = replay_to_host(load("board_reset"))
    assert sum(isinstance(each, DeviceSilent) for each in events) == 1
    assert link.statistics.topic_requests > 3
