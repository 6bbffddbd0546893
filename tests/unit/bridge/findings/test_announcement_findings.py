from __future__ import annotations

from msgspec.structs import replace

from rostether.bridge.findings.announcement_findings import MAX_KEPT, AnnouncementFindings, is_overwritten
from rostether.bridge.findings.finding import Code
from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import AnnouncementRefused, DiscardReason, FrameDiscarded
from rostether.rosserial.packets import TopicInfo

GARBLED = TopicInfo(101, "te\x00mp", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", 280)


def refused(info: TopicInfo) -> FrameDiscarded:
    return FrameDiscarded(DiscardReason.REFUSED, info.encode())


def test_overwritten_names_are_detected() -> None:
    assert is_overwritten(GARBLED)
    assert is_overwritten(replace(GARBLED, topic_name="temp", md5sum=""))
    assert not is_overwritten(replace(GARBLED, topic_name="temp"))
    assert not is_overwritten(replace(GARBLED, topic_name="my topic"))


def test_one_case_may_be_the_line_and_two_are_the_board() -> None:
    announcements = AnnouncementFindings()
    announcements.discarded(refused(GARBLED))
    assert list(announcements.find()) == []
    announcements.discarded(refused(replace(GARBLED, topic_name="te\x7fmp")))
    (finding,) = announcements.find()
    assert finding.code is Code.RAM_OVERFLOW
    assert "\\x00" in finding.seen or "\\x7f" in finding.seen


def test_lengths_that_were_overwritten() -> None:
    announcements = AnnouncementFindings()
    packet = FrameDiscarded(DiscardReason.PACKET, b"\x65\x00\xff\xff\x00\x00temp")
    announcements.discarded(packet)
    announcements.discarded(FrameDiscarded(DiscardReason.PACKET, b"noise that passed its checksum"))
    assert list(announcements.find()) == []
    announcements.discarded(packet)
    announcements.discarded(packet)
    assert [each.code for each in announcements.find()] == [Code.RAM_OVERFLOW]


def test_it_is_reported_which_packets_are_damaged() -> None:
    announcements = AnnouncementFindings()
    for _ in range(3):
        announcements.discarded(FrameDiscarded(DiscardReason.PACKET, b"", ids.LOG))
    (finding,) = announcements.find()
    assert finding.seen.startswith("log lines are damaged inside the board (empty), but the")


def test_a_wrong_but_readable_name_is_a_fault_of_the_sketch() -> None:
    announcements = AnnouncementFindings()
    reason = "a name must start with a letter; write my_topic in the sketch"
    announcements.refused(AnnouncementRefused("my topic", "std_msgs/String", reason))
    (finding,) = announcements.find()
    assert finding.code is Code.NOT_BRIDGED
    assert finding.seen == "my topic [std_msgs/String] is not bridged: a name must start with a letter"
    assert finding.next_step == "write my_topic in the sketch"
    assert finding.is_reported


def test_a_damaged_name_is_reported_once() -> None:
    announcements = AnnouncementFindings()
    announcements.refused(AnnouncementRefused("te\x00mp", "std_msgs/String", "a name must; write it"))
    assert list(announcements.find()) == []


def test_invented_names_do_not_fill_the_memory() -> None:
    announcements = AnnouncementFindings()
    for number in range(1000):
        announcements.discarded(refused(replace(GARBLED, topic_name=f"\x00{number}")))
        announcements.refused(AnnouncementRefused(str(number), "a/B", "no; change it"))
    assert len(list(announcements.find())) <= MAX_KEPT + 1
