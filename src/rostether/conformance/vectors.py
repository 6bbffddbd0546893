"""Test vectors for codecs in other languages: frames and packets with their values, and streams with noise.

    kind     keys
    frame    version, sent_by, topic_id, payload, frame; fields for packets
    stream   bytes, frames: what a decoder finds in the bytes, as pairs of topic id and payload

Bytes are in hexadecimal. The file vectors.jsonl is the specification; tests compare rostether's codecs with
it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib.resources import files
from typing import Any


def read_vectors() -> Iterator[dict[str, Any]]:
    """Yield the vectors, in the order of the protocol's description."""
    text = files("rostether.conformance").joinpath("vectors.jsonl").read_text(encoding="utf-8")
    for line in text.splitlines():
        yield json.loads(line)
