"""Lengths that never come: what is refused at the header, and what is given up while bytes flow."""

from __future__ import annotations

import pytest

from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import DiscardReason, FrameDiscarded, MessagesReceived, TimeRequested
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.frame_decoder import FIRST_SEARCH_S, FrameDecoder, Frames, PayloadLimits
from rostether.rosserial.host_link import HostLink, HostLinkConfig
from rostether.rosserial.packets import TopicInfo
from unit.rosserial.decoding import frame
from unit.rosserial.host_link_boards import BURST, CHATTER, TIME, run_to_settled, settled_link
from unit.rosserial.sessions import STRING, STRING_MD5

GOOD = frame(CHATTER.topic_id, b"\x02\0\0\0hi")


def header(topic_id: int, size: int) -> bytes:
    """The header of a frame whose payload never comes."""
    return encode_frame(topic_id, bytes(size))[:7]


@pytest.mark.parametrize("size", [281, 32767, 65535])
@pytest.mark.parametrize("topic_id", [CHATTER.topic_id, 9999, ids.TIME])
def test_a_length_no_endpoint_can_have_delays_nothing(topic_id: int, size: int) -> None:
    link, now_s = settled_link()
    claim = header(topic_id, size)
    events = link.receive_data(claim + GOOD, now_s)
    if topic_id == ids.TIME and size == 281:  # a control packet may fill the buffer
        return
    assert MessagesReceived(CHATTER.topic_id, [b"\x02\0\0\0hi"]) in events
    discarded = [event for event in events if isinstance(event, FrameDiscarded)]
    assert discarded[0].reason is DiscardReason.TOO_LONG
    assert b"".join(event.data for event in discarded) == claim


def test_announcements_may_be_longer_than_the_buffer_that_they_announce() -> None:
    link, now_s = settled_link()
    long_name = TopicInfo(126, "a" * 240, STRING, STRING_MD5, 280)
    assert len(long_name.encode()) > 280
    events = link.receive_data(frame(ids.PUBLISHER, long_name.encode()), now_s)
    assert any(getattr(event, "info", None) == long_name for event in events)


def test_a_header_seen_before_the_announcement_is_judged_again() -> None:
    link = HostLink()
    link.start(0.0)
    link.receive_data(TIME, 0.001)
    whole = encode_frame(CHATTER.topic_id, bytes(1000))
    link.receive_data(whole, 0.002)
    now_s, _ = run_to_settled(link, 0.01, BURST)
    events = link.receive_data(whole[:7] + GOOD, now_s)
    assert MessagesReceived(CHATTER.topic_id, [b"\x02\0\0\0hi"]) in events


def test_a_board_that_streams_is_limited_to_the_size_of_its_type() -> None:
    streaming = TopicInfo(125, "count", "std_msgs/Int32", "da5909fbe378aeaf85e547e830cc1bb7", 65535)
    burst = TIME + frame(ids.PUBLISHER, streaming.encode())
    good = frame(125, bytes(4))
    for fixed_size, is_refused in ((4, True), (None, False)):

        def size_of(_: TopicInfo, size: int | None = fixed_size) -> int | None:
            return size

        link = HostLink(HostLinkConfig(fixed_size=size_of))
        link.start(0.0)
        now_s, _ = run_to_settled(link, 0.0, burst)
        events = link.receive_data(header(125, 32767) + good, now_s)
        assert (MessagesReceived(125, [bytes(4)]) in events) is is_refused


def test_a_possible_length_is_given_up_while_good_frames_flow_behind_it() -> None:
    decoder = FrameDecoder(limits=PayloadLimits({125: 65535}))
    claim = header(125, 31000)
    found = decoder.feed(claim, 0.0)
    now_s = 0.0
    count = 0
    while not found:
        now_s += 0.02
        count += 1
        found = decoder.feed(GOOD, now_s) + decoder.handle_timer(now_s)
    assert now_s <= FIRST_SEARCH_S + 0.03
    assert found == [
        Frames(125, [b"\x02\0\0\0hi"] * count),
        FrameDiscarded(DiscardReason.UNFINISHED, claim),
    ]


def test_searches_inside_a_possible_length_become_rarer() -> None:
    decoder = FrameDecoder(limits=PayloadLimits({125: 65535}))
    now_s, looks = 0.0, []
    decoder.feed(header(125, 65535), now_s)
    while now_s < 8.0:
        due_s = decoder.get_timer()
        if due_s is not None and due_s <= now_s:
            looks.append(now_s)
            assert decoder.handle_timer(now_s) == []
        now_s += 0.02
        decoder.feed(b"\x00" * 100, now_s)
    assert len(looks) <= 12


def test_the_frames_inside_an_invalid_message_are_returned() -> None:
    link, now_s = settled_link()
    swallowed = header(CHATTER.topic_id, 3) + GOOD + TIME + b"\xff"
    events = link.rescan(swallowed, now_s)
    assert MessagesReceived(CHATTER.topic_id, [b"\x02\0\0\0hi"]) in events
    assert TimeRequested() in events
    assert not any(isinstance(event, FrameDiscarded) for event in events)
    assert link.rescan(b"\xff" * 100, now_s) == []
    link.stop()
    assert link.rescan(swallowed, now_s) == []


def test_looking_inside_uses_the_budget_for_noise() -> None:
    decoder = FrameDecoder()
    noise = b"\xff\xfe\x01\x00\xfe\x7d\x00\x00\x00" * 7000
    found = 0
    for _ in range(20):
        found += len(decoder.rescan(noise + GOOD, 0.0))
    assert found == 20
    assert decoder._false_starts_left < 1000
