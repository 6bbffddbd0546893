from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from rostether.errors import FirmwareError
from rostether.firmware import cache as cache_module
from rostether.firmware.cache import BuildCache, digest, listing


@pytest.fixture
def cache(tmp_path: Path) -> BuildCache:
    return BuildCache(tmp_path / "cache")


def age(path: Path, seconds: float) -> None:
    then = time.time() - seconds
    os.utime(path, (then, then))


def test_a_record_is_valid_until_a_file_changes(cache: BuildCache, tmp_path: Path) -> None:
    source = tmp_path / "source" / "a.cpp"
    source.parent.mkdir()
    source.write_text("int a;")
    age(source, 10)
    cache.save("0" * 32, {"x": 1}, [source], [source.parent], started_ns=time.time_ns())
    assert cache.load("0" * 32) == {"x": 1}
    source.write_text("int b;")
    assert BuildCache(cache.folder).load("0" * 32) is None


def test_a_file_that_was_only_touched_has_not_changed(cache: BuildCache, tmp_path: Path) -> None:
    source = tmp_path / "a.cpp"
    source.write_text("int a;")
    age(source, 10)
    cache.save("0" * 32, {}, [source], [], started_ns=time.time_ns())
    age(source, 5)
    assert BuildCache(cache.folder).load("0" * 32) == {}


def test_a_file_that_changes_while_it_is_compiled_leaves_no_record(cache: BuildCache, tmp_path: Path) -> None:
    source = tmp_path / "a.cpp"
    started_ns = time.time_ns() - 1_000_000_000
    source.write_text("int a;")
    cache.save("0" * 32, {}, [source], [], started_ns=started_ns)
    assert cache.load("0" * 32) is None


def test_a_new_header_may_hide_another(cache: BuildCache, tmp_path: Path) -> None:
    folder = tmp_path / "headers"
    folder.mkdir()
    cache.save("0" * 32, {}, [], [folder], started_ns=time.time_ns())
    (folder / "notes.txt").write_text("")
    assert cache.load("0" * 32) == {}
    (folder / "ros.h").write_text("")
    assert cache.load("0" * 32) is None
    assert listing(tmp_path / "nowhere") == ""


@pytest.mark.parametrize("damage", ["", "{", '{"files": 3}', "\0"])
def test_a_damaged_record_is_ignored(cache: BuildCache, damage: str) -> None:
    cache.save("0" * 32, {}, [], [], started_ns=time.time_ns())
    record = next(cache.folder.rglob("*.json"))
    record.write_text(damage)
    assert cache.load("0" * 32) is None


def test_the_first_of_two_equal_entries_stays(cache: BuildCache) -> None:
    key = digest("same")
    with cache.filling("objects", key) as first, cache.filling("objects", key) as second:
        (first / "unit.o").write_text("1")
        (second / "unit.o").write_text("2")
    assert cache.path("objects", key, "unit.o").read_text() == "2"
    assert [each.name for each in cache.folder.rglob("*") if each.name.startswith(".")] == []


def test_files_are_on_the_disk_before_they_are_found(
    cache: BuildCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[str] = []
    monkeypatch.setattr(
        os, "fsync", lambda file: synced.append(Path(f"/proc/self/fd/{file}").readlink().name)
    )
    with cache.filling("objects", "0" * 32) as folder:
        (folder / "deep").mkdir()
        for name in ("a.o", "deep/b.h"):
            (folder / name).write_text("content")
        assert synced == []
    assert sorted(synced) == ["a.o", "b.h"]


def test_a_failed_block_stores_nothing(cache: BuildCache) -> None:
    with pytest.raises(KeyError), cache.filling("objects", digest("x")) as folder:
        (folder / "unit.o").write_text("half")
        raise KeyError
    assert [each for each in cache.folder.rglob("*") if each.is_file()] == []


def test_the_oldest_entries_are_removed_above_the_limit(
    cache: BuildCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cache_module, "MAX_CACHE_BYTES", 3000)
    monkeypatch.setattr(cache_module, "PRUNE_TO_BYTES", 2500)
    for index in range(4):
        with cache.filling("objects", digest(index)) as folder:
            (folder / "unit.o").write_bytes(bytes(1000))
        for each in (
            cache.path("objects", digest(index), "unit.o"),
            cache.path("objects", digest(index), ""),
        ):
            age(each, 100_000 - index)
    cache.prune(time.time())
    left = [cache.find("objects", digest(index), "unit.o") is not None for index in range(4)]
    assert left[0] is False
    assert left[3] is True


def test_recently_used_entries_stay(cache: BuildCache, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache_module, "MAX_CACHE_BYTES", 10)
    monkeypatch.setattr(cache_module, "PRUNE_TO_BYTES", 5)
    cache.write_text("sources", digest("a"), "a.cpp", "text" * 100)
    cache.prune(time.time())
    assert cache.find("sources", digest("a"), "a.cpp") is not None


def test_the_size_is_not_measured_at_every_build(cache: BuildCache, monkeypatch: pytest.MonkeyPatch) -> None:
    looks: list[float] = []
    monkeypatch.setattr(cache, "_remove_oldest", looks.append)
    now_s = time.time()
    cache.prune(now_s)
    cache.prune(now_s + 60)
    cache.prune(now_s + 2 * cache_module.PRUNE_INTERVAL_S)
    assert len(looks) == 2


def test_a_folder_that_cannot_be_written_is_reported_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FirmwareError, match=r"cannot write to .*file: .*; set XDG_CACHE_HOME"):
        BuildCache(tmp_path / "file").write_text("kind", "0123", "name", "text")
