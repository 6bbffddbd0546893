"""MicroPython finds the same frames as the decoder, in the published vectors and in recorded sessions."""

from __future__ import annotations

from pathlib import Path

from firmware.micropython.boards import PROGRAMS, run
from line_faults import FaultRates, LineFaults
from rostether.conformance.vectors import read_vectors
from rostether.rosserial.frame_decoder import FrameDecoder, Frames
from rostether.transports.memory import Direction
from vectors import captures

# Only a part of each recording, because decoding byte by byte takes time.
LONGEST_STREAM = 5000


def test_micropython_finds_the_same_frames_as_the_decoder(library: Path) -> None:
    streams = [
        bytes.fromhex(each["bytes"] if each["kind"] == "stream" else each["frame"])
        for each in read_vectors()
        if each.get("version", 2) == 2
    ]
    # Both sides of each session: a board's frames have the same layout.
    recorded = [captures.load(name) for name in captures.names() if name != "protocol1"]
    for chunks in (side for each in recorded for side in (each.of_host(), each.of_device())):
        streams.append(b"".join(chunk.data for chunk in chunks)[:LONGEST_STREAM])
        # One byte in a hundred is wrong, missing or inserted.
        faults = LineFaults(FaultRates(0.004, 0.003, 0.003), seed=len(streams))
        streams.append(faults(streams[-1][:1000], Direction.FIRST_TO_SECOND))
    text = "".join(f"{each.hex()}\n" for each in streams)
    lines = run(PROGRAMS / "decode.py", library, text, heap="4m").splitlines()
    # The decoder returns the frames of one topic together.
    assert [sorted(line.split()) for line in lines] == [sorted(_frames(each)) for each in streams]
    assert sum(len(line.split()) for line in lines) > 700


def _frames(data: bytes) -> list[str]:
    decoder = FrameDecoder()
    found = [*decoder.feed(data, 0.0), *decoder.abandon(1.0)]
    groups = [each for each in found if isinstance(each, Frames)]
    return [f"{each.topic_id}:{payload.hex()}" for each in groups for payload in each.payloads]
