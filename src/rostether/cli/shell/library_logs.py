"""Shows the log records of rostether and of asyncio as one line each, never as a traceback."""

from __future__ import annotations

import errno
import logging
import os
from collections.abc import Callable

from rostether.cli.shell.failures import TRACEBACK_VARIABLE
from rostether.cli.shell.output import warn
from rostether.graph.ports import Level
from rostether.mechanisms.rate_limits import LineBudget, RepeatLimiter
from rostether.mechanisms.text import counted, fold_line

_LEVELS = {level.number_in_tens: level for level in Level}
_ROSTETHER = logging.getLogger("rostether")
_ASYNCIO = logging.getLogger("asyncio")
# The limits of open files, of a process and of the whole system.
_EXHAUSTED = (errno.EMFILE, errno.ENFILE)
# The part that identifies a message: asyncio puts the details at the end.
_KIND_CHARACTERS = 40


class _Lines(logging.Handler):
    def __init__(self, show: Callable[[Level, str], None]) -> None:
        super().__init__()
        self.show = show
        # asyncio logs the same message for each connection that it cannot accept.
        self._asyncio_lines = RepeatLimiter()
        # One for each of about fifty messages, because peers decide how often a message is logged.
        self._budgets: dict[str, LineBudget] = {}

    def emit(self, record: logging.LogRecord) -> None:
        kind = str(record.msg)[:_KIND_CHARACTERS]
        if record.name == _ASYNCIO.name and self._asyncio_lines.admit(kind, record.created) is None:
            return
        if record.name != _ASYNCIO.name and record.levelno > logging.DEBUG:
            omitted_count = self._budgets.setdefault(kind, LineBudget()).admit(record.created)
            if omitted_count is None:
                return
            if omitted_count:
                self.show(Level.WARN, f"omitted {counted(omitted_count, 'line')} like the next one")
        text = fold_line(record.getMessage())
        error = record.exc_info[1] if record.exc_info else None
        if isinstance(error, OSError) and error.errno in _EXHAUSTED:
            text = (
                f"new connections wait: {error.strerror}; close programs that connect often, or raise the "
                "limit with `ulimit -n`"
            )
        elif error is not None and not os.environ.get(TRACEBACK_VARIABLE):
            text = f"{text} ({type(error).__name__}: {error}); please report it"
        elif error is not None:
            text = self.format(record)
        self.show(_LEVELS.get(record.levelno, Level.ERROR), text)


def show_library_logs(show: Callable[[Level, str], None] | None = None) -> None:
    """Send warnings and errors to `show`, or write them to stderr as `WARNING: text`.

    A later call replaces an earlier one.
    """
    handler = _Lines(show or _warn)
    for logger in (_ROSTETHER, _ASYNCIO):
        for earlier in [each for each in logger.handlers if isinstance(each, _Lines)]:
            logger.removeHandler(earlier)
        logger.addHandler(handler)


def show_debug_records() -> None:
    """Also show rostether's debug records, such as each change of the state of a board."""
    _ROSTETHER.setLevel(logging.DEBUG)


def _warn(level: Level, text: str) -> None:
    warn(f"{logging.getLevelName(level.number_in_tens)}: {text}")
