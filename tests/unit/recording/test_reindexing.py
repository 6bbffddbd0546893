from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path

import pytest

from rostether.errors import RecordingError
from rostether.recording.checking import file_faults
from rostether.recording.files import Form, create_recording, open_recording
from rostether.recording.reindexing import copy, refuse_same, reindex
from unit.recording.bags import connection, text, write_bag


def test_a_truncated_bag_is_repaired_and_the_original_is_kept(tmp_path: Path) -> None:
    path, backup = tmp_path / "a.bag", tmp_path / "a.orig.bag"
    written = write_bag(path, compression="bz2")
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 2 // 3])
    cut = path.read_bytes()
    mended = reindex(path, path, keep_original=backup)
    reader = open_recording(path)
    found = [each.payload for each in reader.messages()]
    assert mended.damage
    assert 0 < len(found) == mended.message_count < len(written)
    assert found == [payload for _, _, payload in written[: len(found)]]
    assert reader.damage == ""
    assert reader.compressions[0].name == "bz2"
    assert backup.read_bytes() == cut


@pytest.mark.parametrize("name", ["a.bag", "a.mcap"])
@pytest.mark.parametrize("is_closed", [True, False])
def test_only_the_damaged_chunk_is_lost(tmp_path: Path, name: str, is_closed: bool) -> None:
    path, output = tmp_path / name, tmp_path / f"new.{name}"
    writer = create_recording(path, chunk_bytes=300)
    number = writer.add_connection(connection())
    payloads = [text(f"message {index:02}") for index in range(30)]
    for index, payload in enumerate(payloads):
        writer.write(number, index + 1, [payload])
    writer.close()
    data = path.read_bytes()
    middle, end = data.index(b"message 14"), len(data) if is_closed else data.index(b"message 29") + 10
    path.write_bytes(data[:middle] + data[middle + 5 : end])
    mended = reindex(path, output)
    found = [each.payload for each in open_recording(output).messages()]
    assert mended.damage
    assert found == [each for each in payloads if each in found]
    assert found[0] == payloads[0]
    assert found[-1] == payloads[-1]
    assert 24 <= mended.message_count == len(found) < 30


def test_a_complete_bag_is_not_changed(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    write_bag(path)
    before = path.read_bytes()
    assert reindex(path, path, keep_original=tmp_path / "b.bag").damage == ""
    assert path.read_bytes() == before
    assert not (tmp_path / "b.bag").exists()


@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_bag_to_mcap_and_back_keeps_everything(tmp_path: Path, compression: str) -> None:
    first, middle, last = tmp_path / "a.bag", tmp_path / "a.mcap", tmp_path / "b.bag"
    write_bag(first)
    assert copy(open_recording(first), middle, compression=compression) == 30
    assert copy(open_recording(middle), last) == 30
    readers = [open_recording(path) for path in (first, middle, last)]
    assert list(readers[0].messages()) == list(readers[1].messages()) == list(readers[2].messages())
    assert readers[0].counts == readers[1].counts == readers[2].counts
    assert len({reader.span_ns for reader in readers}) == 1


def test_the_input_file_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    write_bag(path)
    with pytest.raises(RecordingError, match="is the input file; give"):
        refuse_same(path, tmp_path / "." / "a.bag")


def test_a_copy_that_fails_leaves_no_file(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    write_bag(path, compression="bz2")
    data = bytearray(path.read_bytes())
    data[data.index(b"BZh") + 20] ^= 0xFF
    path.write_bytes(data)
    with pytest.raises(RecordingError, match="broken"):
        copy(open_recording(path), tmp_path / "b.bag")
    assert not (tmp_path / "b.bag").exists()


def _ros2_folder(folder: Path, storage: str) -> Path:
    """Make a ROS 2 bag, and return the path of its file."""
    bag = folder.with_suffix(".bag")
    write_bag(bag)
    with closing(open_recording(bag)) as reader:
        copy(reader, folder, form=Form.ROS2, storage=storage)
    (file,) = (each for each in folder.iterdir() if each.name != "metadata.yaml")
    return file


def test_the_damaged_file_of_a_ros2_bag_is_repaired(tmp_path: Path) -> None:
    folder = tmp_path / "a"
    file = _ros2_folder(folder, "mcap")
    data = file.read_bytes()
    file.write_bytes(data.replace(b"message 14", b"message 15"))
    repaired = reindex(folder, folder, keep_original=tmp_path / "before")
    assert "checksum" in repaired.damage
    assert file_faults(folder) == []


def test_a_damaged_database_is_not_reported_as_complete(tmp_path: Path) -> None:
    file = _ros2_folder(tmp_path / "a", "sqlite3")
    os.truncate(file, file.stat().st_size - 40)
    for path in (file, file.parent):
        with pytest.raises(RecordingError, match=r"a_0.db3: database disk image is malformed$"):
            reindex(path, path)
