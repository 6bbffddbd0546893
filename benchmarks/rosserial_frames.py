"""The frames per second that the decoder, the encoder and the whole host link process, in chunks of 64 KiB.

`measure()` returns the rows; python -m benchmarks.rosserial_frames prints them.
"""

from __future__ import annotations

import itertools
import random
import time
from collections.abc import Callable
from dataclasses import dataclass

from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import FORMS, encode_frame, encode_frames
from rostether.rosserial.frame_decoder import FrameDecoder
from rostether.rosserial.host_link import HostLink
from rostether.rosserial.packets import TopicInfo

CHUNK_BYTES = 65536
ROUND_S = 0.05
ROUNDS = 8
TOPIC_ID = 125
SUBSCRIBER_ID = 100
MD5SUM = "992ce8a1687cec8c8bd883ec73ca41d1"


@dataclass(frozen=True, slots=True)
class Row:
    """One operation; `rate_hz` in frames a second, `wanted_hz` is 0 without a goal."""

    operation: str
    rate_hz: float
    wanted_hz: float


def measure() -> list[Row]:
    """Measure everything on one core, the best of several rounds."""
    rng = random.Random(1)
    rows = []
    for size, wanted_hz in ((0, 0.0), (64, 1.2e6), (320, 0.5e6), (4096, 0.0)):
        payloads = _payloads(rng, size)
        chunk = encode_frames(TOPIC_ID, payloads)
        rows.append(_row(f"decode {size} B, one topic", _decode(chunk), len(payloads), wanted_hz))
    payloads = _payloads(rng, 64)
    mixed = b"".join(encode_frame(TOPIC_ID + number % 10, payload) for number, payload in enumerate(payloads))
    rows.append(_row("decode 64 B, ten topics in turn", _decode(mixed), len(payloads), 0.0))
    broken = bytearray(mixed)
    stride = 64 + FORMS[2].overhead_bytes
    for position in range(20, len(broken), 20 * stride):
        broken[position] ^= 0xFF
    rows.append(_row("decode 64 B, 5 % damaged", _decode(bytes(broken)), len(payloads), 0.0))
    link = _settled_link()
    chunk = encode_frames(TOPIC_ID, payloads)
    rows.append(_row("host link receives 64 B", lambda: link.receive_data(chunk, 1.0), len(payloads), 1.2e6))
    rows.append(
        _row(
            "host link encodes 64 B",
            lambda: link.encode_messages(SUBSCRIBER_ID, payloads),
            len(payloads),
            0.6e6,
        )
    )
    rows.append(
        _row(
            "host link encodes 64 B, one by one",
            lambda: [link.encode_message(SUBSCRIBER_ID, payload) for payload in payloads],
            len(payloads),
            0.0,
        )
    )
    return rows


def hostile() -> list[tuple[str, float]]:
    """Return (name, megabytes a second) for bytes that are slow to decode."""
    claim = encode_frame(TOPIC_ID, bytes(60000))[: FORMS[2].header_bytes]
    lines = {
        "beginnings of frames": b"\xff\xfe" * (CHUNK_BYTES // 2),
        "headers that claim 60 kB": claim * (CHUNK_BYTES // len(claim)),
        "random bytes": random.Random(1).randbytes(CHUNK_BYTES),
    }
    return [(name, len(data) * _rate_hz(_decode(data)) / 1e6) for name, data in lines.items()]


def _payloads(rng: random.Random, size: int) -> list[bytes]:
    return [rng.randbytes(size) for _ in range(CHUNK_BYTES // (size + FORMS[2].overhead_bytes))]


def _decode(chunk: bytes) -> Callable[[], object]:
    decoder = FrameDecoder()
    # The search for frames in noise has a limit for each second; here it applies to each chunk.
    seconds = itertools.count()

    def work() -> object:
        now_s = float(next(seconds))
        decoded = decoder.feed(chunk, now_s)
        decoder.abandon(now_s)
        return decoded

    return work


def _settled_link() -> HostLink:
    link = HostLink()
    link.start(0.0)
    for kind, topic_id in ((ids.PUBLISHER, TOPIC_ID), (ids.SUBSCRIBER, SUBSCRIBER_ID)):
        info = TopicInfo(topic_id, f"topic_{topic_id}", "std_msgs/String", MD5SUM, 512)
        link.receive_data(encode_frame(kind, info.encode()), 0.0)
    return link


def _row(operation: str, work: Callable[[], object], count: int, wanted_hz: float) -> Row:
    return Row(operation, count * _rate_hz(work), wanted_hz)


def _rate_hz(work: Callable[[], object]) -> float:
    best_s = float("inf")
    for _ in range(ROUNDS):
        calls = 0
        began_s = time.perf_counter()
        while (elapsed_s := time.perf_counter() - began_s) < ROUND_S:
            work()
            calls += 1
        best_s = min(best_s, elapsed_s / calls)
    return 1 / best_s


def main() -> None:
    """Print the rows."""
    for row in measure():
        wanted = f"   wanted {row.wanted_hz / 1e6:.1f}" if row.wanted_hz else ""
        print(f"{row.operation:36} {row.rate_hz / 1e6:6.2f} M/s{wanted}")
    for name, rate_mb_s in hostile():
        print(f"hostile: {name:27} {rate_mb_s:6.1f} MB/s")


if __name__ == "__main__":
    main()
