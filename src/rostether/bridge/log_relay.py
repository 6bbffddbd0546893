"""Passes a board's log lines to the graph, under its node's name, and to people."""

from __future__ import annotations

from rostether.bridge.reporter import Notices
from rostether.graph.ports import Level
from rostether.rosserial.packets import LogLevel

_LEVELS = {
    LogLevel.DEBUG: Level.DEBUG,
    LogLevel.INFO: Level.INFO,
    LogLevel.WARN: Level.WARN,
    LogLevel.ERROR: Level.ERROR,
    LogLevel.FATAL: Level.FATAL,
}


def relay_log(level: LogLevel, text: str, notices: Notices) -> None:
    """Pass on one log line."""
    notices.report(_LEVELS[level], text)
