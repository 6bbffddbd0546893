"""The frame decoder: garbage never raises, chunks change nothing, and what it keeps is bounded."""

from __future__ import annotations

from rostether.rosserial.frame import MAX_PAYLOAD_BYTES, VERSIONS, encode_frame, encode_frames
from rostether.rosserial.frame_decoder import Decoded, FrameDecoder, Frames
from vectors.captures import load, names

HEADER_BYTES = 8
SEED_BYTES = 4000


def seeds() -> list[bytes]:
    """Return recorded sessions, and frames that lie about their length."""
    made = [bytes([version]) + encode_frame(125, b"abc", version=version) for version in VERSIONS]
    made.append(b"\x02" + encode_frames(10, [b"", b"x" * 300]) + b"\xff\xfe\xff\xff\x00")
    return made + [
        b"\x02" + b"".join(each.data for each in capture.of_device())[:SEED_BYTES]
        for capture in map(load, names())
    ]


def run(data: bytes) -> None:
    """Decode in one piece and in two."""
    version = VERSIONS[data[0] % len(VERSIONS)] if data else VERSIONS[0]
    stream = data[1:]
    whole, cut = FrameDecoder(version), FrameDecoder(version)
    expected = messages(whole.feed(stream, 0.0))
    middle = data[0] * len(stream) // 256 if data else 0
    found = messages([*cut.feed(stream[:middle], 0.0), *cut.feed(stream[middle:], 0.0)])
    assert found == expected, "the chunks change what is decoded"
    assert whole.pending_bytes <= MAX_PAYLOAD_BYTES + HEADER_BYTES
    whole.abandon(1e6)
    whole.handle_timer(1e6)


def messages(decoded: list[Decoded]) -> dict[int, list[bytes]]:
    """Return the payloads by topic id, in their order: between topics there is none."""
    found: dict[int, list[bytes]] = {}
    for each in decoded:
        if isinstance(each, Frames):
            found.setdefault(each.topic_id, []).extend(each.payloads)
    return found
