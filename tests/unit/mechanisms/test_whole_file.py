from __future__ import annotations

import errno
import os
import re
import resource
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from rostether.cli.shell.output import write_file
from rostether.errors import ConfigError
from rostether.mechanisms.state_file import load_state, store_state
from rostether.mechanisms.whole_file import write_whole


@pytest.fixture
def full_disk() -> Iterator[None]:
    """Fail each write beyond 1 kB, as a full disk does."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, ignored)


@pytest.mark.usefixtures("full_disk")
def test_a_full_disk_leaves_no_part_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "graph.svg"
    with pytest.raises(ConfigError, match=r"cannot write .*/graph.svg: File too large"):
        write_file(path, "x" * 2000)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(OSError, match=re.escape(f"'{path}'")):
        write_whole(path, b"x" * 2000)
    write_file(path, "old")
    with pytest.raises(ConfigError):
        write_file(path, "x" * 2000)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_target_of_a_link_is_written(tmp_path: Path) -> None:
    path, link, pipe = tmp_path / "file", tmp_path / "link", tmp_path / "pipe"
    path.write_text("old")
    path.chmod(0o640)
    link.symlink_to(path)
    write_whole(link, b"new")
    assert link.is_symlink()
    assert path.read_text() == "new"
    assert path.stat().st_mode & 0o777 == 0o640
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        write_whole(pipe, b"through")
        assert os.read(reader, 100) == b"through"
    finally:
        os.close(reader)
    with pytest.raises(OSError, match="directory"):
        write_whole(tmp_path, b"")


def test_a_replaced_file_gets_the_wanted_permissions(tmp_path: Path) -> None:
    path = tmp_path / "key.pem"
    path.write_text("old")
    path.chmod(0o644)
    write_whole(path, b"new", mode=0o600)
    assert (path.read_text(), path.stat().st_mode & 0o777) == ("new", 0o600)


def test_values_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "new" / "state.json"
    store_state(path, {"a": 1})
    store_state(path, {"b": [2]})
    assert load_state(path, 1000) == {"format": 1, "b": [2]}
    assert [each.name for each in path.parent.iterdir()] == ["state.json"]


def test_a_disk_that_fails_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "state.json"
    store_state(path, {"a": 1}, is_durable=True)
    synced: list[str] = []

    def fail(descriptor: int) -> None:
        synced.append(Path(f"/proc/self/fd/{descriptor}").readlink().name)
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="Input/output error"):
        store_state(path, {"a": 2}, is_durable=True)
    # The content is on the disk before it gets the name.
    assert synced == [f".state.json.{os.getpid()}"]
    assert load_state(path, 1000) == {"format": 1, "a": 1}
    assert [each.name for each in tmp_path.iterdir()] == ["state.json"]


@pytest.mark.parametrize("text", ["", "{", "[]", '{"format": 2, "a": 1}', "[" * 100_000])
def test_a_file_with_other_content_counts_as_missing(tmp_path: Path, text: str) -> None:
    path = tmp_path / "state.json"
    assert load_state(path, 1000) == {}
    path.write_text(text)
    assert load_state(path, 1_000_000) == {}


def test_a_file_that_is_too_long_counts_as_missing(tmp_path: Path) -> None:
    path = tmp_path / "state.json"
    store_state(path, {"a": "long" * 100})
    assert load_state(path, 100) == {}
