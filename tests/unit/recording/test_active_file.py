from __future__ import annotations

import shutil
from pathlib import Path

from rostether.recording.active_file import end_active
from rostether.recording.reindexing import reindex
from rostether.recording.ros2.db3_reader import Db3Reader
from rostether.recording.ros2.db3_writer import Db3Writer
from unit.recording.bags import START_NS, connection, text


def _unclosed(active: Path, count: int) -> None:
    """Leave what is there when a full disk kept a file from being closed."""
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
    for count in (3, 5):  # the second over the first
        _unclosed(active, count)
        assert active.with_name("a.db3.active-wal").stat().st_size
        end_active(active, path)
        assert not list(tmp_path.glob("*.active*"))
    assert _count(path) == 5


def test_a_closed_file_does_not_get_the_log_of_the_one_before(tmp_path: Path) -> None:
    active, path = tmp_path / "a.db3.active", tmp_path / "a.db3"
    _unclosed(active, 3)
    end_active(active, path)
    writer = Db3Writer(active)
    writer.write(writer.add_connection(connection()), START_NS, [text("one")])
    writer.close()
    end_active(active, path)
    assert [each.name for each in tmp_path.iterdir()] == ["a.db3"]
    assert _count(path) == 1


def test_reindex_takes_what_stands_in_the_log(tmp_path: Path) -> None:
    active, path, original = tmp_path / "a.db3.active", tmp_path / "a.db3", tmp_path / "a.orig.db3"
    _unclosed(active, 3)
    end_active(active, path)
    assert reindex(path, path, keep_original=original).message_count == 3
    assert _count(path) == 3
    _unclosed(active, 3)
    assert reindex(active, path, keep_original=original).message_count == 3
    assert (_count(path), _count(original)) == (3, 3)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.db3", "a.orig.db3"]
