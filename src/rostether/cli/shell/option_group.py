"""Groups of options: added to a verb in one step and passed to it as one value."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, TypeVar

import click

Function = TypeVar("Function", bound=Callable[..., Any])


def option_group(
    name: str, build: Callable[..., object], options: Sequence[Callable[[Any], Any]]
) -> Callable[[Function], Function]:
    """Return a decorator that adds click options to a verb.

    The verb gets one argument `name`, which is what `build` returns. The parameters of `build` have the names
    of the options; a parameter whose option the verb does not have keeps its default.
    """
    parameters = inspect.signature(build).parameters

    def decorate(function: Function) -> Function:
        @wraps(function)
        def with_value(*args: Any, **kwargs: Any) -> Any:
            typed = {each: kwargs.pop(each) for each in parameters if each in kwargs}
            return function(*args, **{name: build(**typed)}, **kwargs)

        decorated: Any = with_value
        for option in reversed(options):
            decorated = option(decorated)
        return decorated  # type: ignore[no-any-return]

    return decorate


def ignored_options(*names: str, **flags: str) -> Callable[[Function], Function]:
    """Return a decorator that accepts options of other programs and ignores them.

    Args:
        names: Options with a value, such as `"--spin-time"`; spellings of one option are separated by spaces.
        flags: Options without a value, `long="-l --long"`.
    """

    def decorate(function: Function) -> Function:
        decorated: Any = function
        for spellings in names:
            decorated = click.option(*spellings.split(), expose_value=False, hidden=True)(decorated)
        for spellings in flags.values():
            decorated = click.option(*spellings.split(), is_flag=True, expose_value=False, hidden=True)(
                decorated
            )
        return decorated  # type: ignore[no-any-return]

    return decorate
