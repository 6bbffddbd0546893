"""Log records are shown as one line, never as a traceback."""

from __future__ import annotations

import errno
import logging
import os
from collections.abc import Iterator

import pytest

from rostether.cli.shell.library_logs import show_debug_records, show_library_logs
from rostether.graph.ports import Level
from rostether.mechanisms import rate_limits

LIBRARY_LOG = logging.getLogger("rostether.ros1")
ASYNCIO = logging.getLogger("asyncio")


@pytest.fixture(autouse=True)
def _loggers_as_before() -> Iterator[None]:
    loggers = (logging.getLogger("rostether"), ASYNCIO)
    before = [(list(logger.handlers), logger.level) for logger in loggers]
    yield
    for logger, (handlers, level) in zip(loggers, before, strict=True):
        logger.handlers = handlers
        logger.setLevel(level)


def test_warning_goes_to_the_reporter() -> None:
    shown: list[tuple[Level, str]] = []
    show_library_logs(lambda level, text: shown.append((level, text)))
    LIBRARY_LOG.warning("the master\nis %s", "away")
    LIBRARY_LOG.info("not shown")
    assert shown == [(Level.WARN, "the master is away")]


def test_terminal_controls_of_peers_are_escaped() -> None:
    shown: list[str] = []
    show_library_logs(lambda _level, text: shown.append(text))
    LIBRARY_LOG.warning("%s is gone", "\x1b]0;x\x07/node")
    assert shown == ["\\u001b]0;x\\u0007/node is gone"]


def test_last_call_counts() -> None:
    first: list[str] = []
    second: list[str] = []
    show_library_logs(lambda _level, text: first.append(text))
    show_library_logs(lambda _level, text: second.append(text))
    LIBRARY_LOG.error("gone")
    assert (first, second) == ([], ["gone"])


def test_stderr_without_a_reporter(capsys: pytest.CaptureFixture[str]) -> None:
    show_library_logs()
    LIBRARY_LOG.warning("slow")
    assert capsys.readouterr().err == "WARNING: slow\n"


def test_forgotten_exception_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROSTETHER_TRACEBACK", raising=False)
    shown: list[str] = []
    show_library_logs(lambda _level, text: shown.append(text))
    ASYNCIO.error("Task exception was never retrieved", exc_info=ValueError("odd"))
    assert shown == ["Task exception was never retrieved (ValueError: odd); please report it"]


def test_too_many_open_files_are_not_a_defect() -> None:
    shown: list[str] = []
    show_library_logs(lambda _level, text: shown.append(text))
    error = OSError(errno.EMFILE, os.strerror(errno.EMFILE))
    ASYNCIO.error("socket.accept() out of system resource", exc_info=error)
    (text,) = shown
    assert "ulimit -n" in text
    assert "report" not in text


def test_traceback_on_request(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSTETHER_TRACEBACK", "1")
    shown: list[str] = []
    show_library_logs(lambda _level, text: shown.append(text))
    try:
        raise ValueError("odd")
    except ValueError:
        ASYNCIO.exception("failed")
    assert "Traceback" in shown[0]


def test_repeated_records_do_not_fill_the_log(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[str] = []
    show_library_logs(lambda _level, text: shown.append(text))
    for number in range(1000):
        ASYNCIO.error("socket.accept() out of system resource\nsocket: %s", number)
        LIBRARY_LOG.warning("node %s is gone", number)
    assert len([text for text in shown if "accept" in text]) == 1
    # One line of asyncio, and twenty of each of rostether's loggers.
    assert len(shown) == 21
    monkeypatch.setattr(rate_limits, "PERIOD_S", 0.0)
    ASYNCIO.error("socket.accept() out of system resource\nsocket: %s", 1000)
    assert shown[-1] == "socket.accept() out of system resource socket: 1000"


def test_debug_records_show_on_request() -> None:
    shown: list[tuple[Level, str]] = []
    show_library_logs(lambda level, text: shown.append((level, text)))
    LIBRARY_LOG.debug("hidden")
    show_debug_records()
    LIBRARY_LOG.debug("presence ABSENT -> PRESENT")
    assert shown == [(Level.DEBUG, "presence ABSENT -> PRESENT")]
