from __future__ import annotations

import os
import subprocess
import sys

import pytest

from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.graph.ports import Level


def test_lines_look_as_rospy_s(capsys: pytest.CaptureFixture[str]) -> None:
    reporter = ConsoleReporter(clock=lambda: 1700000000.1234567)
    reporter.report(Level.INFO, "Connecting to /dev/ttyACM0 at 57600 baud")
    reporter.report(Level.INFO, "Note: publish buffer size is 280 bytes", node="/board")
    reporter.report(Level.WARN, "slow", node="/board")
    reporter.report(Level.DEBUG, "not shown")
    captured = capsys.readouterr()
    assert captured.out == (
        "[INFO] [1700000000.123457]: Connecting to /dev/ttyACM0 at 57600 baud\n"
        "[INFO] [1700000000.123457]: /board: Note: publish buffer size is 280 bytes\n"
    )
    assert captured.err == "[WARN] [1700000000.123457]: /board: slow\n"


def test_one_board_needs_no_name_and_verbose_shows_more(capsys: pytest.CaptureFixture[str]) -> None:
    reporter = ConsoleReporter(show_node=False, lowest=Level.DEBUG, clock=lambda: 1.0)
    reporter.report(Level.DEBUG, "hello", node="/serial_node")
    assert capsys.readouterr().out == "[DEBUG] [1.000000]: hello\n"


def test_unread_lines_block_nothing() -> None:
    code = """
from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.graph.ports import Level
input()
reporter = ConsoleReporter()
for number in range(3):
    reporter.report(Level.INFO, f"line {number}")
import os
os.write(2, b"still there")
"""
    reading, writing = os.pipe()
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=writing, stderr=subprocess.PIPE, text=True
    )
    os.close(writing)
    os.close(reading)
    _, errors = process.communicate("go\n", timeout=60)
    assert (process.returncode, errors) == (0, "still there")
