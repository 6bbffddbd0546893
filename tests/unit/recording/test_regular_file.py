from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import RecordingError
from rostether.recording.regular_file import MappedFile


def test_a_file_is_mapped_and_released(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"abc")
    file = MappedFile(path)
    assert (bytes(file.view), file.size_bytes) == (b"abc", 3)
    kept = file.view[1:]
    file.close()
    file.close()
    assert bytes(kept) == b"bc"


def test_errors_name_the_path_that_cannot_be_read(tmp_path: Path) -> None:
    empty = tmp_path / "empty"
    empty.touch()
    with pytest.raises(RecordingError, match="empty is empty"):
        MappedFile(empty)
    with pytest.raises(RecordingError, match=r"cannot read .*none: No such file"):
        MappedFile(tmp_path / "none")
