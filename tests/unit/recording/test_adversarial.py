"""Files whose few bytes would need much memory: they are refused in one line, with little memory."""

from __future__ import annotations

import bz2
import resource
import struct
import subprocess
import sys
from pathlib import Path

import lz4.frame
import pytest
import zstandard

from rostether.errors import RecordingError
from rostether.recording.bag import chunks as bag_chunks
from rostether.recording.bag.reader import BagReader
from rostether.recording.bag.records import MAGIC, U32, Op, bag_header, encode_record
from rostether.recording.compression import MAX_CHUNK_BYTES, decompress
from rostether.recording.mcap import content as mcap_content
from rostether.recording.mcap.reader import McapReader
from rostether.recording.mcap.records import CHUNK_HEAD, encode_text
from rostether.recording.mcap.records import MAGIC as MCAP_MAGIC
from rostether.recording.mcap.records import Op as McapOp
from rostether.recording.mcap.records import encode_record as encode_mcap

PACKED = {
    "bz2": bz2.compress,
    "lz4": lz4.frame.compress,
    "zstd": zstandard.ZstdCompressor().compress,
}


def _bag(plain: bytes, size: int | None = None) -> bytes:
    size_field = U32.pack(len(plain) if size is None else size)
    chunk = encode_record(Op.CHUNK, {b"compression": b"bz2", b"size": size_field}, bz2.compress(plain))
    return MAGIC + bag_header(0, 0, 0) + chunk


@pytest.mark.parametrize("name", PACKED)
def test_data_that_unpacks_to_more_than_its_stated_size_is_refused(name: str) -> None:
    packed = PACKED[name](bytes(10_000_000))
    with pytest.raises(RecordingError, match="has 101 bytes instead of 100"):
        decompress(name, packed, 100)
    with pytest.raises(RecordingError, match="instead of 10000001"):
        decompress(name, packed, 10_000_001)
    with pytest.raises(RecordingError, match="has a wrong size"):
        decompress(name, packed, MAX_CHUNK_BYTES + 1)
    with pytest.raises(RecordingError, match=f"compressed with {name} is broken|instead of"):
        decompress(name, b"\x00" + packed, 10_000_000)
    assert decompress(name, packed, 10_000_000) == bytes(10_000_000)


def test_too_many_connections_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bag_chunks, "MAX_CONNECTIONS", 100)
    records = [
        encode_record(Op.CONNECTION, {b"conn": U32.pack(number), b"topic": b"/a%d" % number}, b"")
        for number in range(1000)
    ]
    path = tmp_path / "a.bag"
    path.write_bytes(_bag(b"".join(records)))
    reader = BagReader(path)
    assert "it has more than 100 connections or 256 MiB of definitions" in reader.damage
    assert len(reader.counts) == 100


def test_too_large_definitions_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mcap_content, "MAX_DEFINITION_BYTES", 10_000)
    schema = encode_mcap(McapOp.SCHEMA, struct.pack("<H", 1) + encode_text("a/B") + encode_text("") * 2)
    plain = schema * 10_000
    packed = lz4.frame.compress(plain)
    head = CHUNK_HEAD.pack(0, 0, len(plain), 0) + encode_text("lz4") + struct.pack("<Q", len(packed))
    path = tmp_path / "a.mcap"
    path.write_bytes(MCAP_MAGIC + encode_mcap(1, bytes(8)) + encode_mcap(McapOp.CHUNK, head + packed))
    assert "it has more than 10000 bytes of definitions" in McapReader(path).damage


@pytest.mark.slow
def test_a_few_bytes_that_unpack_to_many_need_bounded_memory(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    path.write_bytes(_bag(bytes(MAX_CHUNK_BYTES // 2)))
    assert path.stat().st_size < 10_000
    ended = subprocess.run(
        [sys.executable, "-m", "rostether", "bag", "info", str(path)],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30)),
        capture_output=True,
        text=True,
        check=True,
    )
    assert "has no kind" in ended.stderr
