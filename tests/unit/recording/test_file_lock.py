from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from rostether.errors import RecordingError
from rostether.recording import file_lock
from rostether.recording.bag.reader import BagReader
from rostether.recording.file_lock import FileLock, end_active
from rostether.recording.files import create_recording, open_recording
from rostether.recording.reindexing import copy, reindex
from rostether.recording.ros2.db3_reader import Db3Reader
from rostether.recording.ros2.db3_writer import Db3Writer
from unit.recording.bags import START_NS, connection, text, write_bag


def test_a_second_writer_is_refused_until_the_first_ends(tmp_path: Path) -> None:
    path = tmp_path / "a.bag.active"
    with FileLock(path), pytest.raises(RecordingError, match=r"a\.bag\.active is being written by another"):
        FileLock(path)
    FileLock(path).release()


def test_a_new_file_without_content_is_removed(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    FileLock(path).release()
    assert not path.exists()
    path.touch()
    FileLock(path).release()
    assert path.exists()


def test_a_file_renamed_while_it_is_locked_is_not_the_new_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.bag.active"
    path.write_bytes(b"first")
    is_same = file_lock._is_same

    def is_same_after_renaming(file: int, path: Path) -> bool:
        monkeypatch.setattr(file_lock, "_is_same", is_same)
        path.replace(tmp_path / "a.bag")
        return is_same(file, path)

    monkeypatch.setattr(file_lock, "_is_same", is_same_after_renaming)
    lock = FileLock(path)
    path.write_bytes(b"second")
    lock.release()
    assert (tmp_path / "a.bag").read_bytes() == b"first"
    FileLock(tmp_path / "a.bag").release()


def test_a_path_that_cannot_be_written_gets_no_lock(tmp_path: Path) -> None:
    FileLock(tmp_path / "missing" / "a.bag").release()
    FileLock(tmp_path).release()


@pytest.mark.parametrize("suffix", [".bag", ".mcap", ".db3"])
def test_every_format_can_be_locked_and_written(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}.active"
    path.write_bytes(b"what a killed recorder left")
    with FileLock(path):
        writer = create_recording(path)
        with pytest.raises(RecordingError, match="is being written"):
            FileLock(path)
        writer.write(writer.add_connection(connection()), START_NS, [text("one")])
        writer.close()
    reader = open_recording(path)
    assert sum(reader.counts.values()) == 1
    reader.close()


def test_a_recording_being_written_is_neither_repaired_nor_overwritten(tmp_path: Path) -> None:
    live, source = tmp_path / "live.bag", tmp_path / "source.bag"
    write_bag(live, closes=False)
    write_bag(source)
    before = live.read_bytes()
    with FileLock(live):
        with pytest.raises(RecordingError, match="is being written"):
            reindex(live, live, keep_original=tmp_path / "orig.bag")
        reader = BagReader(source)
        with pytest.raises(RecordingError, match="is being written"):
            copy(reader, live)
        reader.close()
    assert live.read_bytes() == before
    assert sorted(each.name for each in tmp_path.iterdir()) == ["live.bag", "source.bag"]


def _unclosed(active: Path, count: int) -> None:
    """Write the files that remain when a full disk prevented closing."""
    writer = Db3Writer(active.with_name("other"))
    writer.write(writer.add_connection(connection()), START_NS, [text("one")] * count)
    writer.flush()
    for each in sorted(active.parent.glob("other*")):
        shutil.copy(each, active.with_name(each.name.replace("other", active.name)))
    writer.close()
    (active.with_name("other")).unlink()


def _count(path: Path) -> int:
    reader = Db3Reader(path)
    try:
        return sum(1 for _ in reader.messages())
    finally:
        reader.close()


def test_a_file_that_sqlite_could_not_close_keeps_its_log(tmp_path: Path) -> None:
    active, path = tmp_path / "a.db3.active", tmp_path / "a.db3"
    for count in (3, 5):  # the second file replaces the first
        _unclosed(active, count)
        assert active.with_name("a.db3.active-wal").stat().st_size
        end_active(active, path)
        assert not list(tmp_path.glob("*.active*"))
    assert _count(path) == 5


def test_a_closed_file_does_not_get_the_log_of_an_earlier_file(tmp_path: Path) -> None:
    active, path = tmp_path / "a.db3.active", tmp_path / "a.db3"
    _unclosed(active, 3)
    end_active(active, path)
    writer = Db3Writer(active)
    writer.write(writer.add_connection(connection()), START_NS, [text("one")])
    writer.close()
    end_active(active, path)
    assert [each.name for each in tmp_path.iterdir()] == ["a.db3"]
    assert _count(path) == 1


def test_reindex_reads_the_messages_in_the_log(tmp_path: Path) -> None:
    active, path, original = tmp_path / "a.db3.active", tmp_path / "a.db3", tmp_path / "a.orig.db3"
    _unclosed(active, 3)
    end_active(active, path)
    assert reindex(path, path, keep_original=original).message_count == 3
    assert _count(path) == 3
    _unclosed(active, 3)
    assert reindex(active, path, keep_original=original).message_count == 3
    assert (_count(path), _count(original)) == (3, 3)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.db3", "a.orig.db3"]
