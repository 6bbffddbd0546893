"""The API frames of an XBee radio: chunks do not change the result, and no report stops the listener.

The decoder's frames are compared with those of a simple reader that follows the specification.
"""

from __future__ import annotations

import random

from fuzz.grammar import damaged, near
from rostether.transports.xbee.frame import MAX_FRAME_BYTES, XbeeFrameDecoder, encode_frame
from rostether.transports.xbee.host_radio import HostRadio
from rostether.transports.xbee.packets import (
    MAX_PAYLOAD_BYTES,
    AtAnswer,
    RadioPacket,
    TransmitStatus,
    parse_report,
)
from rostether.transports.xbee.send_queue import QUEUE_LIMIT_BYTES, WINDOW_PACKETS, SendQueue

DELIMITER, ESCAPE = b"\x7e", 0x7D
KINDS = (0x80, 0x81, 0x88, 0x89, 0x8B, 0x90, 0x91)
COMMANDS = (b"AP", b"NH", b"NP", b"DB", b"XX")


def seeds() -> list[bytes]:
    """Return an answer, a status and a packet in both modes, and a frame that is too long."""
    reports = (b"\x88\x01NP\x00\x00\x64", b"\x89\x01\x00", b"\x81\x00\x07\x28\x00~}hello")
    return [
        *(bytes([mode]) + encode_frame(each, escaped=bool(mode)) for each in reports for mode in (0, 1)),
        b"\x00" + encode_frame(bytes(MAX_FRAME_BYTES + 1), escaped=False),
    ]


def generate(source: random.Random) -> bytes:
    """Return frames of one mode that a radio could send; some are too short, too long or damaged."""
    choice = source.randrange(256)
    parts = []
    for _ in range(source.randint(1, 6)):
        size = near(source, MAX_FRAME_BYTES) % 400 if source.random() < 0.3 else source.randint(0, 14)
        body = bytes((source.choice(KINDS), source.randint(0, 3)))
        report = (body + source.choice(COMMANDS) + b"\x00" + source.randbytes(size))[: max(1, size)]
        made = encode_frame(report, escaped=bool(choice % 2))
        parts.append(damaged(source, made) if source.random() < 0.2 else made)
    return bytes([choice]) + b"".join(parts)


def run(data: bytes) -> None:
    """Decode the data in one piece and in two, and with the simple reader; then pass it to a listener."""
    is_escaped = bool(data[0] % 2) if data else True
    stream = data[1:]
    middle = data[0] * len(stream) // 256 if data else 0
    whole, cut = (XbeeFrameDecoder(escaped=is_escaped) for _ in range(2))
    found = whole.feed(stream)
    assert [*cut.feed(stream[:middle]), *cut.feed(stream[middle:])] == found, "the chunks change the frames"
    assert found == (read_escaped(stream) if is_escaped else read_plain(stream)), (
        "the decoder and the simple reader find different frames"
    )
    handle(found)


def read_escaped(stream: bytes) -> list[bytes]:
    """Return the frames of API mode 2: a delimiter occurs only at the beginning of a frame."""
    found = []
    for part in stream.split(DELIMITER)[1:]:
        plain, is_escaped = bytearray(), False
        for byte in part:
            if byte == ESCAPE:
                is_escaped = True
                continue
            plain.append(byte ^ 0x20 if is_escaped else byte)
            is_escaped = False
        found += read_plain(DELIMITER + plain)[:1] if is_whole(bytes(plain)) else []
    return found


def read_plain(stream: bytes) -> list[bytes]:
    """Return the frames of API mode 1."""
    found = []
    start = stream.find(DELIMITER)
    while start >= 0 and len(stream) >= start + 3:
        length = int.from_bytes(stream[start + 1 : start + 3], "big")
        if length > MAX_FRAME_BYTES:
            start = stream.find(DELIMITER, start + 3)
            continue
        end = start + 3 + length + 1
        if end > len(stream):
            break
        if sum(stream[start + 3 : end]) % 256 == 0xFF:
            found.append(stream[start + 3 : end - 1])
        start = stream.find(DELIMITER, end)
    return found


def is_whole(plain: bytes) -> bool:
    """Return whether the first frame, given without its delimiter, is complete and valid."""
    length = int.from_bytes(plain[:2], "big")
    body = plain[2 : 2 + length + 1]
    return len(plain) >= 3 + length <= 3 + MAX_FRAME_BYTES and sum(body) % 256 == 0xFF


def handle(frames: list[bytes]) -> None:
    """Handle the reports like a listener; its queues and its output stay bounded."""
    radio = HostRadio()
    queue: SendQueue[int] = SendQueue(lambda: radio.packet_bytes)
    for now_s, frame in enumerate(frames):
        match parse_report(frame):
            case AtAnswer() as answer:
                radio.answered(answer)
            case TransmitStatus() as status:
                queue.finished(status)
            case RadioPacket() as packet:
                queue.note_received(packet.source)
                queue.put(packet.source, packet.payload)
                assert queue.waiting_bytes(packet.source) <= QUEUE_LIMIT_BYTES
        assert 1 <= radio.packet_bytes <= MAX_PAYLOAD_BYTES
        sent = list(queue.next_packets(now_s))
        assert len(sent) <= WINDOW_PACKETS
        for each in sent:
            assert XbeeFrameDecoder().feed(radio.encode(each))
        queue.give_up(now_s)
