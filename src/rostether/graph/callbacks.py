"""Checks and runs the callbacks of a graph's user, and keeps their errors out of the data path."""

from __future__ import annotations

import logging
from collections.abc import Callable
from inspect import iscoroutinefunction
from typing import ParamSpec, TypeVar

_Args = ParamSpec("_Args")
_Result = TypeVar("_Result")
_log = logging.getLogger("rostether.graph")


def call_safely(
    what: str, callback: Callable[_Args, _Result], *args: _Args.args, **kwargs: _Args.kwargs
) -> _Result | None:
    """Return a callback's result; log its exception in one line that names `what`, and return None."""
    try:
        return callback(*args, **kwargs)
    except Exception as error:  # noqa: BLE001 - an error in a callback must not end a connection
        report_error(what, error)
        return None


def report_error(what: str, error: BaseException) -> None:
    """Log one line for the error of a callback; the traceback only if debugging is on."""
    _log.error("%s failed: %s: %s", what, type(error).__name__, error)
    _log.debug("traceback of this failure", exc_info=error)


def require_callable(what: str, function: object) -> None:
    """Raise TypeError unless the function can be called: later, each call would fail far from the mistake."""
    if not callable(function):
        raise TypeError(
            f"the {what} must be a function, not {function!r:.40}; write the function's name without ()"
        )


def require_plain(what: str, function: object, advice: str) -> None:
    """Raise TypeError, with the advice, unless the function can be called and is not async."""
    require_callable(what, function)
    if iscoroutinefunction(function):
        raise TypeError(f"the {what} is async; {advice}")
