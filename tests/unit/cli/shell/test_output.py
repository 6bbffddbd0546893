"""What peers say is printed, and steers no terminal."""

from __future__ import annotations

import json

import pytest

from rostether.cli.shell.output import warn, write_json, write_line

EVIL = "a\x1b[2J\x9b31m\u202e\x7f\r\nFAKE\tb\u00e4\u6c34"


def test_lines_and_tabs_stay_while_controls_are_escaped(capsys: pytest.CaptureFixture[str]) -> None:
    shown = "a\\u001b[2J\\u009b31m\\u202e\\u007f\\r\nFAKE\tb\u00e4\u6c34"
    write_line(EVIL)
    warn(EVIL)
    assert capsys.readouterr() == (f"{shown}\n", f"{shown}\n")


def test_json_stays_json(capsys: pytest.CaptureFixture[str]) -> None:
    write_json({"name": EVIL})
    out = capsys.readouterr().out
    assert json.loads(out) == {"name": EVIL}
    assert "\x9b" not in out
