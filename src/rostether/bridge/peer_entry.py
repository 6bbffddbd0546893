"""What makes the sender of a datagram a board: a frame. Its address alone is easily forged."""

from __future__ import annotations

from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import MAX_PAYLOAD_BYTES, encode_frame
from rostether.rosserial.protocol_detector import ProtocolDetector
from rostether.transports.peers import PeerEntry


def holds_frame(data: bytes) -> bool:
    """Tell whether a sound frame of either protocol version is in `data`."""
    detector = ProtocolDetector(max_payload_bytes=MAX_PAYLOAD_BYTES, limits={})
    detector.feed(data, 0.0)
    return detector.decoder is not None


BOARD_ENTRY = PeerEntry(holds_frame, encode_frame(ids.TOPIC_REQUEST, b""))
