"""Recorded sessions of established hosts, played to the node: it receives every message."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware.node.programs import build_program, run
from rostether.rosserial import topic_id
from rostether.rosserial.frame_decoder import FrameDecoder, Frames
from vectors import captures
from vectors.captures import Capture

# The program's endpoint for each type in the recordings.
ENDPOINTS = {
    ("subscriber", "std_msgs/Empty"): "empty",
    ("subscriber", "std_msgs/String"): "text",
    ("subscriber", "std_msgs/Byte"): "byte",
    ("service server, request", "rosserial_arduino/Test"): "server",
    ("service client, response", "rosserial_arduino/Test"): "client",
}
# The first host speaks protocol 1, which the node does not; the type of the other is in a package that is not
# bundled.
SKIPPED = ("protocol1", "mearm")


def endpoints(capture: Capture) -> list[str]:
    """Return the board's endpoints that receive, by topic id."""
    expected = [(topic.kind, topic.type) for _, topic in sorted(capture.topics.items())]
    return [ENDPOINTS[each] for each in expected if each in ENDPOINTS]


def count_frames_of_host(capture: Capture) -> dict[int, int]:
    """Return the number of frames of each topic id that the host sent."""
    decoder = FrameDecoder()
    counts: dict[int, int] = {}
    for chunk in capture.of_host():
        for each in decoder.feed(chunk.data, chunk.time_s):
            if isinstance(each, Frames):
                counts[each.topic_id] = counts.get(each.topic_id, 0) + len(each.payloads)
    return counts


@pytest.mark.gcc
@pytest.mark.timeout(300)
@pytest.mark.parametrize("name", [each for each in captures.names() if each not in SKIPPED])
def test_messages_of_recorded_hosts_are_received(name: str, library: Path) -> None:
    capture = captures.load(name)
    sent = count_frames_of_host(capture)
    chunks = "".join(f"{int(each.time_s * 1000)} {each.data.hex()}\n" for each in capture.of_host())
    program = build_program("gcc", "sessions", library)
    lines = run(program, *endpoints(capture), stdin=chunks).splitlines()
    reported = [int(line.split()[1]) for line in lines if line.startswith("sent")]
    received = sum(line.startswith("heard") for line in lines)
    messages = sum(count for each, count in sent.items() if each >= topic_id.FIRST_USER_ID)
    # A response between two calls belongs to no call.
    assert 0 < received <= messages if "client" in endpoints(capture) else received == messages
    # Each topic request is answered; there are also announcements without a request.
    assert reported.count(topic_id.PUBLISHER) >= sent[topic_id.PUBLISHER]
    assert reported.count(topic_id.TIME) >= sent[topic_id.PUBLISHER]
    answers = sent.get(topic_id.TIME, 0)
    now = int(lines[-1].split()[1])
    assert (now > 1_000_000_000) == (answers > 0)
    unexpected = sent.get(topic_id.PARAMETER, 0)
    assert int(lines[-2].split()[1]) == unexpected
