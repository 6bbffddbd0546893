"""Text from peers is printed without control characters."""

from __future__ import annotations

import json
import sys

import click
import pytest

from rostether.cli.shell.output import (
    has_colors,
    paint_finding,
    paint_frame,
    paint_keys,
    warn,
    write_json,
    write_line,
)

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


def test_colors_are_for_terminals_only(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    write_line("x: 1", paint_keys)
    assert capsys.readouterr().out == "x: 1\n"
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    assert has_colors()
    # Text from peers is escaped before.
    write_line("x: \x1b[31m", paint_keys)
    assert capsys.readouterr().out == f"{click.style('x:', fg='cyan')} \\u001b[31m\n"
    for name, value in (("NO_COLOR", "1"), ("TERM", "dumb")):
        with monkeypatch.context() as changed:
            changed.setenv(name, value)
            assert not has_colors()


def test_keys_of_yaml_and_labels() -> None:
    text = "header:\n  frame_id: 'a: b'\n- x: 1\n  text\n---"
    painted = paint_keys(text)
    assert click.unstyle(painted) == text
    for key in ("header:", "frame_id:", "x:"):
        assert click.style(key, fg="cyan") in painted
    assert painted.endswith(click.style("---", dim=True))


def test_findings_and_frames() -> None:
    for line, word in (
        ("  error no_answer: silent", "error"),
        ("PROBLEM: graph: no", "PROBLEM"),
        ("    next: unplug it", "next"),
        ("  no problem found", "no problem found"),
    ):
        assert click.unstyle(paint_finding(line)) == line
        assert f"{word}\x1b[0m" in paint_finding(line)
    assert paint_finding("/dev/ttyACM0 at 57600 baud") == "/dev/ttyACM0 at 57600 baud"
    line = "│  └─ tool (static)"
    assert click.unstyle(paint_frame(line)) == line
    assert click.style("tool", bold=True) in paint_frame(line)
