from __future__ import annotations

from pathlib import Path

import pytest

from rostether.ports.known_boards import MAX_BOARDS, KnownBoards


def test_baud_rates_are_stored(tmp_path: Path) -> None:
    path = tmp_path / "state" / "boards.json"
    KnownBoards(path).remember("usb 75", 115200)
    assert KnownBoards(path).baud_of("usb 75") == 115200
    assert KnownBoards(path).baud_of("usb 76") is None


def test_an_unchanged_rate_is_not_written(tmp_path: Path) -> None:
    path = tmp_path / "boards.json"
    known = KnownBoards(path)
    known.remember("a", 9600)
    path.unlink()
    known.remember("a", 9600)
    assert not path.exists()
    known.remember("a", 57600)
    assert path.exists()


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{", '{"format": 2, "bauds": {"a": 1}}', '{"format": 1, "bauds": [1]}', "\x00"],
)
def test_an_unreadable_file_counts_as_empty(text: str, tmp_path: Path) -> None:
    path = tmp_path / "boards.json"
    path.write_text(text)
    known = KnownBoards(path)
    assert known.baud_of("a") is None
    known.remember("a", 9600)
    assert KnownBoards(path).baud_of("a") == 9600


def test_invalid_baud_rates_are_skipped(tmp_path: Path) -> None:
    path = tmp_path / "boards.json"
    path.write_text('{"format": 1, "bauds": {"a": -1, "b": true, "c": "9600", "d": 9600}}')
    known = KnownBoards(path)
    assert [known.baud_of(key) for key in "abcd"] == [None, None, None, 9600]


def test_the_board_that_was_not_seen_for_longest_is_removed() -> None:
    known = KnownBoards()
    for number in range(MAX_BOARDS):
        known.remember(str(number), 9600)
    known.remember("0", 9600)
    known.remember("new", 9600)
    assert known.baud_of("0") == 9600
    assert known.baud_of("1") is None


def test_a_folder_that_cannot_be_written_is_ignored(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    known = KnownBoards(tmp_path / "file" / "boards.json")
    known.remember("a", 9600)
    assert known.baud_of("a") == 9600
