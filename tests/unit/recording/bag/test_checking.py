from __future__ import annotations

from pathlib import Path

import pytest

from rostether.recording.bag.checking import faults_of
from rostether.recording.bag.records import Op, op_of, read_record
from rostether.recording.bag.writer import BagWriter
from rostether.recording.files import open_recording
from rostether.recording.reindexing import reindex
from unit.recording.bags import write_bag, write_reset


@pytest.fixture
def data(tmp_path: Path) -> bytearray:
    write_bag(tmp_path / "a.bag")
    return bytearray((tmp_path / "a.bag").read_bytes())


def _first(data: bytearray, op: int) -> tuple[int, int]:
    position = 13
    while True:
        before = position
        fields, start, position = read_record(bytes(data), position)
        if op_of(fields) == op:
            return before, start


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_written_bags_have_no_faults(tmp_path: Path, compression: str) -> None:
    write_bag(tmp_path / "a.bag", compression=compression)
    assert faults_of((tmp_path / "a.bag").read_bytes()) == []


@pytest.mark.parametrize(
    ("place", "reported"),
    [
        (0, "is not the listed message of connection"),
        (4, "is not the listed message of connection"),
        (8, "the index after it is wrong"),
    ],
)
def test_an_index_with_a_wrong_time_or_offset_is_reported(data: bytearray, place: int, reported: str) -> None:
    _, start = _first(data, Op.INDEX)
    data[start + place] ^= 0x11
    (fault,) = faults_of(bytes(data))
    assert reported in fault


def test_an_index_of_another_connection_is_reported(data: bytearray) -> None:
    before, _ = _first(data, Op.INDEX)
    data[data.index(b"conn=", before) + 5] ^= 1
    (fault,) = faults_of(bytes(data))
    assert "the index after it is wrong" in fault


def test_wrong_counts_and_times_in_the_bags_index_are_reported(data: bytearray) -> None:
    before, start = _first(data, Op.CHUNK_INFO)
    data[start + 4] ^= 1
    data[data.index(b"end_time=", before) + 9] ^= 1
    counts, times = faults_of(bytes(data))
    assert "the bag's index has a wrong number of messages" in counts
    assert "its times are" in times


def test_a_broken_chunk_is_reported(tmp_path: Path) -> None:
    write_bag(tmp_path / "a.bag", compression="bz2")
    data = bytearray((tmp_path / "a.bag").read_bytes())
    _, start = _first(data, Op.CHUNK)
    data[start + 30] ^= 0xFF
    (fault,) = faults_of(bytes(data))
    assert "compressed with bz2 is broken" in fault


@pytest.mark.parametrize("chunk_bytes", [300, 100_000])
def test_a_time_that_goes_back_is_reported_and_can_be_repaired(tmp_path: Path, chunk_bytes: int) -> None:
    path = tmp_path / "a.bag"
    write_reset(BagWriter(path, chunk_bytes=chunk_bytes))
    (fault,) = faults_of(path.read_bytes())
    assert fault.startswith("its time goes back once from 1029.00 s to 1.00 s")
    assert reindex(path, path).message_count == 50
    assert faults_of(path.read_bytes()) == []
    reader = open_recording(path)
    times = [each.time_ns for each in reader.messages()]
    reader.close()
    assert len(times) == 50
    assert times == sorted(times)
