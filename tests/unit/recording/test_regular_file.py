from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path

import pytest

from rostether.errors import RecordingError
from rostether.recording.files import create_recording, open_recording
from rostether.recording.regular_file import MappedFile
from unit.recording.bags import connection, text


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


@pytest.mark.parametrize("suffix", ["bag", "mcap"])
def test_a_recording_that_another_program_shortens_is_reported(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a.{suffix}"
    with closing(create_recording(path, chunk_bytes=300)) as writer:
        number = writer.add_connection(connection())
        for index in range(3000):
            writer.write(number, index, [text(f"message {index}")])
    with closing(open_recording(path)) as reader:
        messages = reader.messages()
        next(messages)
        os.truncate(path, 8192)
        with pytest.raises(RecordingError, match="another program has shortened it"):
            list(messages)


def test_reading_after_close_does_not_read_another_file(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"abc")
    file = MappedFile(path)
    file.close()
    with (tmp_path / "b").open("wb+") as other:  # It may get the number of the closed file.
        other.write(b"xyz")
        other.flush()
        with pytest.raises(ValueError, match="released"):
            file.read(0, 3)
