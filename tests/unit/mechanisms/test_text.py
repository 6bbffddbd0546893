"""Texts of peers are shown, but do not control the terminal."""

from __future__ import annotations

import errno
import json
import os
import sqlite3

import pytest

from rostether.mechanisms.text import (
    counted,
    escape_line,
    escape_text,
    fold_line,
    listed,
    misfit_text,
    read_failure,
    write_failure,
)

EVIL = "a\x1b[2J\x9b31m\u202e\x7f\r\nFAKE\tb\u00e4\u6c34"


def test_lines_and_tabs_stay_while_controls_are_escaped() -> None:
    shown = "a\\u001b[2J\\u009b31m\\u202e\\u007f\\r\nFAKE\tb\u00e4\u6c34"
    assert escape_text(EVIL) == shown
    assert escape_text(shown) == shown


def test_a_name_is_one_line() -> None:
    assert escape_line(EVIL) == "a\\u001b[2J\\u009b31m\\u202e\\u007f\\r\\nFAKE\\tb\u00e4\u6c34"


def test_white_space_folds_into_one_space() -> None:
    assert fold_line("  no such\n    thing:\t\x1b[2J ") == "no such thing: \\u001b[2J"


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (
            OSError(errno.ENOSPC, "No space left"),
            "cannot write a.bag: No space left; free some space on its disk",
        ),
        (OSError(errno.EACCES, "Denied"), "cannot write a.bag: Denied; choose a writable folder"),
        (
            sqlite3.OperationalError("database or disk is full"),
            "cannot write a.bag: database or disk is full; free some space on its disk",
        ),
        (
            OSError(errno.EEXIST, os.strerror(errno.EEXIST)),
            "cannot write a.bag: File exists; choose another name",
        ),
    ],
)
def test_a_file_that_cannot_be_written_has_a_next_step(error: Exception, text: str) -> None:
    assert write_failure("a.bag", error) == text


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (errno.ENOENT, "cannot read a.bag: No such file or directory; check the path"),
        (errno.EACCES, "cannot read a.bag: Permission denied; make it readable for this user"),
        (errno.EIO, "cannot read a.bag: Input/output error; check its disk"),
    ],
)
def test_an_error_of_reading_names_the_next_step(number: int, text: str) -> None:
    assert read_failure("a.bag", OSError(number, os.strerror(number))) == text


@pytest.mark.parametrize("hidden", ["\x00", "\u200b", "\u2066", "\ufeff", "\udc80", "\U000e0041"])
def test_what_is_invisible_shows_and_stays_json(hidden: str) -> None:
    text = json.dumps({"name": hidden}, ensure_ascii=False)
    assert escape_text(text).isprintable()
    assert json.loads(escape_text(text)) == {"name": hidden}


@pytest.mark.parametrize("text", ["grün 水", "a\u00a0b\u3000c", "🤖"])
def test_typed_values_are_unchanged(text: str) -> None:
    assert escape_line(text) == text


def test_a_line_is_cut_at_its_limit() -> None:
    assert escape_line("x" * 500, 500) == "x" * 500
    assert escape_line("x" * 501, 500) == "x" * 497 + "..."
    assert escape_line("\x1b" * 501, 500).startswith("\\u001b" * 80)
    assert len(escape_line("\x1b" * 501, 500)) == 500


@pytest.mark.parametrize(("number", "text"), [(0, "0 bytes"), (1, "1 byte"), (2, "2 bytes")])
def test_a_noun_has_its_number(number: int, text: str) -> None:
    assert counted(number, "byte") == text


def test_misfits_agree_with_their_number() -> None:
    assert misfit_text(1) == "1 message does not fit its type"
    assert misfit_text(2) == "2 messages do not fit their type"


@pytest.mark.parametrize(
    ("texts", "text"),
    [([], ""), (["a"], "a"), (["a", "b"], "a, b"), (["a", "b", "c"], "a, b and 1 more")],
)
def test_a_list_is_limited(texts: list[str], text: str) -> None:
    assert listed(texts, 2) == text
