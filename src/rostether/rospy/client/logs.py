"""rospy.loginfo and related functions: they log to the terminal, to /rosout and to the file of `__log:=`."""

from __future__ import annotations

import logging
import os
import sys
import threading
import time
from collections.abc import Callable
from typing import Any, TextIO

from rostether.graph.log_message import ROSOUT
from rostether.graph.ports import Level
from rostether.rospy.client.names import get_name, names
from rostether.rospy.client.ros_time import Duration, Time, simulated_time_s

DEBUG, INFO, WARN, ERROR, FATAL = map(int, Level)

# The levels of rosgraph_msgs/Log by those of the module logging.
LEVELS = {level.number_in_tens: level for level in Level}
_COLORS = {Level.DEBUG: "\033[32m", Level.WARN: "\033[33m", Level.ERROR: "\033[31m", Level.FATAL: "\033[31m"}
_FORMAT = "[${severity}] [${time}]: ${message}"
_FILE_FORMAT = "[%(name)s][%(levelname)s] %(asctime)s: %(message)s"

# As in rospy: the size of a node's log file, and the number of older files that are kept.
_BYTES_PER_FILE = 50_000_000
_FILES_KEPT = 4

_rosout_logger = logging.getLogger("rosout")
_last_logged: dict[Any, Any] = {}
_last_texts: dict[Any, str] = {}
_logged_once: set[Any] = set()


class TerminalHandler(logging.Handler):
    """Prints like rospy: information on standard output, warnings and errors on standard error.

    ROSCONSOLE_FORMAT changes the format.
    """

    def emit(self, record: logging.LogRecord) -> None:
        """Print one record."""
        level = LEVELS.get(record.levelno, Level.INFO)
        wall = f"{time.time():f}"
        ros_time = simulated_time_s()
        values = {
            "severity": level.name,
            "message": logging.Formatter().format(record),
            "walltime": wall,
            "time": wall if ros_time is None else f"{wall}, {ros_time:f}",
            "thread": f"{record.thread}",
            "logger": record.name,
            "file": record.pathname,
            "line": f"{record.lineno}",
            "function": record.funcName,
            "node": get_name(),
        }
        text = os.environ.get("ROSCONSOLE_FORMAT", _FORMAT)
        for key, value in values.items():
            text = text.replace(f"${{{key}}}", value)
        stream: TextIO = sys.stdout if record.levelno < logging.WARNING else sys.stderr
        if stream.isatty() and level in _COLORS:
            text = f"{_COLORS[level]}{text}\033[0m"
        stream.write(f"{text}\n")


class RosoutHandler(logging.Handler):
    """Publishes records on /rosout."""

    def __init__(self, publish: Callable[[logging.LogRecord], None]) -> None:
        super().__init__()
        self._publish = publish
        self._inside = threading.local()

    def emit(self, record: logging.LogRecord) -> None:
        """Publish one record; records about its own errors are not published."""
        if getattr(self._inside, "flag", False):
            return
        self._inside.flag = True
        try:
            self._publish(record)
        except Exception:  # noqa: BLE001 - a log line that cannot be published must not end the program
            self.handleError(record)
        finally:
            self._inside.flag = False


def configure(log_level: int | None) -> None:
    """Start to print, and to write the file of `__log:=`. Idempotent."""
    if not any(isinstance(handler, TerminalHandler) for handler in _rosout_logger.handlers):
        _rosout_logger.addHandler(TerminalHandler())
        # Problems of the node's connections, such as a topic that has another type.
        handler: logging.Handler = TerminalHandler()
        handler.setLevel(logging.WARNING)
        logging.getLogger("rostether").addHandler(handler)
        if file := names.mappings.get("__log"):
            from logging.handlers import RotatingFileHandler

            handler = RotatingFileHandler(
                file, maxBytes=_BYTES_PER_FILE, backupCount=_FILES_KEPT, delay=True, encoding="utf-8"
            )
            handler.setFormatter(logging.Formatter(_FILE_FORMAT))
            logging.getLogger().addHandler(handler)
            logging.getLogger().setLevel(logging.INFO)
    _rosout_logger.setLevel(logging.INFO if log_level is None else Level(log_level).number_in_tens)


def publish_logs(publish: Callable[[logging.LogRecord], None]) -> None:
    """Start to publish logs on /rosout."""
    _rosout_logger.addHandler(RosoutHandler(publish))


def log_fields(record: logging.LogRecord, topics: list[str]) -> dict[str, Any]:
    """Return the fields of a rosgraph_msgs/Log, without its stamp."""
    return {
        "level": LEVELS.get(record.levelno, Level.INFO).value,
        "name": get_name(),
        "msg": logging.Formatter().format(record),
        "topics": topics if ROSOUT in topics else [*topics, ROSOUT],
        "file": record.filename,
        "line": record.lineno,
        "function": record.funcName,
    }


def _log(level: int, msg: Any, args: tuple[Any, ...], kwargs: dict[str, Any]) -> None:
    name = kwargs.pop("logger_name", None)
    logger = _rosout_logger.getChild(name) if name else _rosout_logger
    if not logger.isEnabledFor(level):
        return
    frame = sys._getframe(2)
    function = frame.f_code.co_name
    if "self" in frame.f_locals:
        function = f"{type(frame.f_locals['self']).__name__}.{function}"
    exc_info = kwargs.get("exc_info")
    record = logger.makeRecord(
        logger.name,
        level,
        frame.f_code.co_filename,
        frame.f_lineno,
        msg,
        args,
        None if not exc_info else exc_info if isinstance(exc_info, tuple) else sys.exc_info(),
        function,
        kwargs.get("extra"),
    )
    logger.handle(record)


def _statement() -> tuple[str, int, int]:
    """Return the file, line and instruction of the program's log statement."""
    frame = sys._getframe(2)
    return frame.f_code.co_filename, frame.f_lineno, frame.f_lasti


def _is_due(statement: Any, period: float) -> bool:
    now = Time.now()
    last = _last_logged.get(statement)
    if last is None or now - last > Duration(period) or last > now:
        _last_logged[statement] = now
        return True
    return False


def _is_new_text(statement: Any, text: Any) -> bool:
    is_new = _last_texts.get(statement) != str(text)
    _last_texts[statement] = str(text)
    return is_new


def _log_functions(level: int) -> tuple[Callable[..., None], ...]:
    """Return the plain, throttled, throttled-if-identical and once-only functions of one level."""

    def log(msg: Any, *args: Any, **kwargs: Any) -> None:
        """Log a text, with arguments as in `logging`."""
        _log(level, msg, args, kwargs)

    def log_throttle(period: float, msg: Any, *args: Any, **kwargs: Any) -> None:
        """Log at most once in `period` seconds from this statement."""
        if _is_due(_statement(), period):
            _log(level, msg, args, kwargs)

    def log_throttle_identical(period: float, msg: Any, *args: Any, **kwargs: Any) -> None:
        """Log a new text immediately, the same text at most once in `period` seconds."""
        statement = _statement()
        is_due = _is_due(statement, period)
        if _is_new_text(statement, msg) or is_due:
            _log(level, msg, args, kwargs)

    def log_once(msg: Any, *args: Any, **kwargs: Any) -> None:
        """Log the first time that this statement is reached."""
        statement = _statement()
        if statement not in _logged_once:
            _logged_once.add(statement)
            _log(level, msg, args, kwargs)

    return log, log_throttle, log_throttle_identical, log_once


logdebug, logdebug_throttle, logdebug_throttle_identical, logdebug_once = _log_functions(logging.DEBUG)
loginfo, loginfo_throttle, loginfo_throttle_identical, loginfo_once = _log_functions(logging.INFO)
logwarn, logwarn_throttle, logwarn_throttle_identical, logwarn_once = _log_functions(logging.WARNING)
logerr, logerr_throttle, logerr_throttle_identical, logerr_once = _log_functions(logging.ERROR)
logfatal, logfatal_throttle, logfatal_throttle_identical, logfatal_once = _log_functions(logging.CRITICAL)
logout = loginfo
logerror = logerr
