"""Checks the functions that programs pass to be called later."""

from __future__ import annotations

from inspect import iscoroutinefunction


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
