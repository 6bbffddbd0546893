"""Recognizes the sender of a datagram as a board by a frame, and proves its address by an answer.

A sender with a forged address receives nothing from us, so it does not know when to answer.
"""

from __future__ import annotations

from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import MAX_PAYLOAD_BYTES, encode_frame
from rostether.rosserial.frame_decoder import Frames
from rostether.rosserial.host_output import PROBE
from rostether.rosserial.protocol_detector import ProtocolDetector
from rostether.transports.peers import PeerEntry

_ANSWERS = frozenset({*ids.ANNOUNCEMENTS, ids.PARAMETER})


def holds_frame(data: bytes) -> bool:
    """Return whether a valid frame of either protocol version is in `data`."""
    return bool(_frames_in(data))


def holds_answer(data: bytes) -> bool:
    """Return whether `data` has a frame that boards send only after they received data from the host.

    That is an announcement, or a parameter request of a board without topics.
    """
    return any(frames.topic_id in _ANSWERS for frames in _frames_in(data))


def _frames_in(data: bytes) -> list[Frames]:
    detector = ProtocolDetector(max_payload_bytes=MAX_PAYLOAD_BYTES)
    decoded = detector.feed(data, 0.0)
    if detector.decoder is None:
        return []
    return [each for each in decoded if isinstance(each, Frames)]


BOARD_ENTRY = PeerEntry(
    is_frame=holds_frame, request=encode_frame(ids.TOPIC_REQUEST, b""), is_answer=holds_answer, call=PROBE
)
