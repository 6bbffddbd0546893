from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from rostether.mechanisms.state_file import load_state, store_state


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
