"""The published vectors: the codecs agree with them, and the page of the protocol shows them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from rostether.conformance.vectors import read_vectors
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.frame_decoder import FrameDecoder, Frames
from rostether.rosserial.packets import Log, ParameterRequest, ParameterResponse, TopicInfo, decode_time

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "wire-protocol.md"
VECTORS = {each["name"]: each for each in read_vectors()}


def frames_in(version: int, data: bytes, piece_bytes: int) -> list[list[Any]]:
    """Decode a stream that arrives in pieces; an incomplete frame at its end is dropped."""
    decoder = FrameDecoder(version)
    pieces = [data[at : at + piece_bytes] for at in range(0, len(data), piece_bytes)]
    found = [each for piece in pieces for each in decoder.feed(piece, 0.0)]
    found += decoder.abandon(1.0)
    groups = [each for each in found if isinstance(each, Frames)]
    return [[each.topic_id, payload.hex()] for each in groups for payload in each.payloads]


def read_fields(vector: dict[str, Any], payload: bytes) -> dict[str, Any]:
    """Decode the packet of a frame, by its topic id and its sender."""
    topic_id = vector["topic_id"]
    packet: Any
    if topic_id in ids.ANNOUNCEMENTS:
        packet = TopicInfo.decode(payload)
    elif topic_id == ids.PARAMETER:
        packet = (ParameterRequest if vector["sent_by"] == "client" else ParameterResponse).decode(payload)
    elif topic_id == ids.LOG:
        level, text = Log.decode(payload) or (None, None)
        return {"level": level, "msg": text}
    else:
        packet = decode_time(payload)
    values = {key: getattr(packet, key) for key in vector["fields"]}
    return {key: list(value) if isinstance(value, tuple) else value for key, value in values.items()}


@pytest.mark.parametrize("vector", VECTORS.values(), ids=VECTORS)
def test_our_codecs_agree(vector: dict[str, Any]) -> None:
    if vector["kind"] == "stream":
        data, version = bytes.fromhex(vector["bytes"]), 2
        wanted = vector["frames"]
    else:
        data, version, payload = (
            bytes.fromhex(vector["frame"]),
            vector["version"],
            bytes.fromhex(vector["payload"]),
        )
        wanted = [[vector["topic_id"], vector["payload"]]]
        assert encode_frame(vector["topic_id"], payload, version) == data
        if "fields" in vector:
            assert read_fields(vector, payload) == vector["fields"]
    assert frames_in(version, data, len(data)) == frames_in(version, data, 1) == wanted


def test_the_page_has_the_bytes_of_the_vectors() -> None:
    blocks = re.findall(
        r"^`([a-z0-9-]+)`[^\n]*\n\n```text\n(.*?)^```", PAGE.read_text(), re.MULTILINE | re.DOTALL
    )
    for name, body in blocks:
        shown = "".join(re.findall(r"^((?:[0-9a-f]{2} )*[0-9a-f]{2})(?:  |$)", body, re.MULTILINE))
        assert shown.replace(" ", "") == VECTORS[name]["frame"], name
    # One of each packet.
    shown_ids = {VECTORS[name]["topic_id"] for name, _ in blocks}
    assert shown_ids >= {0, 1, 2, 3, 4, 5, 6, 7, 10, 11, 125}
