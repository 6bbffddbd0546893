from __future__ import annotations

import struct

import pytest
from websockets.client import ClientProtocol
from websockets.frames import Frame
from websockets.protocol import OPEN
from websockets.uri import parse_uri

from rostether.gateways.foxglove.data_outlet import add_data_frames


@pytest.mark.parametrize("size", [0, 1, 112, 113, 65535 - 13, 65536 - 13, 200_000])
def test_frames_are_what_the_websocket_library_reads(size: int) -> None:
    payloads = [bytes(size), b"second"]
    pieces: list[bytes] = []
    assert add_data_frames(pieces, 7, 123456789012345, payloads) == len(b"".join(pieces))
    client = ClientProtocol(parse_uri("ws://localhost"), state=OPEN, max_size=None)
    client.receive_data(b"".join(pieces))
    frames = [event for event in client.events_received() if isinstance(event, Frame)]
    header = struct.pack("<BIQ", 1, 7, 123456789012345)
    assert [bytes(frame.data) for frame in frames] == [header + payload for payload in payloads]
    assert all(frame.fin and frame.opcode == 2 for frame in frames)
