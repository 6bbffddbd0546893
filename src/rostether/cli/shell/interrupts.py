"""Handles Ctrl-C outside of event loops: before a command's first loop, and between two loops."""

from __future__ import annotations

import signal

_interrupted = False


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
