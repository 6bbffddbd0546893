"""Handles signals outside of event loops: before a command's first loop, between two, or without any."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator

_interrupted = False


class TerminatedError(BaseException):
    """A signal ended the command; `exit_code` is the one that a shell reports for this signal."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.exit_code = 128 + number


@contextlib.contextmanager
def cleaning_up() -> Iterator[None]:
    """Raise TerminatedError at SIGTERM, or when the terminal is closed, so that the block removes its files.

    Without this, these signals would leave incomplete files with the names of complete ones.
    """

    def end(number: int, _frame: object) -> None:
        # A second signal must not end the clean-up.
        signal.signal(number, signal.SIG_IGN)
        raise TerminatedError(number)

    # Windows has no SIGHUP; nohup ignores it.
    numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    handled = [each for each in numbers if signal.getsignal(each) is signal.SIG_DFL]
    for number in handled:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in handled:
            signal.signal(number, signal.SIG_DFL)


def raise_at_interrupt() -> None:
    """From now on, raise KeyboardInterrupt at Ctrl-C; until now, it ended the process (see `__main__`)."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:
        signal.signal(signal.SIGINT, _interrupt)


def was_interrupted() -> bool:
    """Return whether Ctrl-C was pressed: Python may lose the KeyboardInterrupt in a clean-up."""
    return _interrupted


def note_interrupt() -> None:
    """Make the next event loop end immediately."""
    global _interrupted
    _interrupted = True


def _interrupt(_number: int, _frame: object) -> None:
    note_interrupt()
    raise KeyboardInterrupt
