from __future__ import annotations

import pytest

from rostether.bridge.reporter import Notices
from rostether.bridge.sync_report import SyncReport
from rostether.rosserial.events import DeviceSilent, DiscardReason, FrameDiscarded
from unit.bridge.doubles import RecordingReporter


@pytest.fixture
def reporter() -> RecordingReporter:
    return RecordingReporter()


def report(reporter: RecordingReporter, baud: int | None = 57600) -> SyncReport:
    return SyncReport(Notices(reporter, "/board", lambda: 0.0), baud)


def noise(data: bytes) -> FrameDiscarded:
    return FrameDiscarded(DiscardReason.NOISE, data)


def test_a_board_that_never_answered(reporter: RecordingReporter) -> None:
    report(reporter).silent(DeviceSilent(3.0))
    (said,) = reporter.texts
    assert "no answer from the board for 3 s" in said
    assert "57600" in said


def test_without_a_baud_rate_none_is_blamed(reporter: RecordingReporter) -> None:
    report(reporter, None).silent(DeviceSilent(3.0))
    assert "baud" not in reporter.texts[0]


def test_text_on_the_line_is_shown(reporter: RecordingReporter) -> None:
    watched = report(reporter)
    watched.discarded(noise(b"Hello from "))
    watched.discarded(noise(b"setup()\r\n"))
    watched.silent(DeviceSilent(3.0))
    assert "'Hello from setup()\\r\\n'" in reporter.texts[0]
    assert "20 other bytes" in reporter.texts[0]


def test_noise_is_shown_as_bytes_and_the_baud_rate_suspected(reporter: RecordingReporter) -> None:
    watched = report(reporter)
    for _ in range(1000):
        watched.discarded(noise(b"\xf8\x00\x86\xfe"))
    watched.silent(DeviceSilent(3.0))
    assert "f8 00 86 fe" in reporter.texts[0]
    assert "baud rate other than 57600" in reporter.texts[0]
    assert len(reporter.texts[0]) < 300


def test_a_board_that_fell_silent_and_came_back(reporter: RecordingReporter) -> None:
    watched = report(reporter)
    watched.alive()
    watched.silent(DeviceSilent(3.0))
    watched.silent(DeviceSilent(3.0))
    assert len(reporter.having("has been silent")) == 1
    watched.alive()
    watched.silent(DeviceSilent(3.0))
    assert len(reporter.having("has been silent")) == 2
