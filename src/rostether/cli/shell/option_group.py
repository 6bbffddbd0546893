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


class OptionalValueOption(click.Option):
    """An option whose value may be left out.

    Args:
        alone: The value of the option when none is given. is_value: Returns whether the next word of the
        command line is the option's value.
    """

    def __init__(self, *args: Any, alone: str, is_value: Callable[[str], bool], **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._alone = alone
        self._is_value = is_value

    def insert_value(self, arguments: list[str]) -> list[str]:
        """Return the command line with `--option=alone` where the option has no value."""
        return insert_value(arguments, self.opts[0], self._alone, self._is_value)


def insert_value(arguments: list[str], option: str, alone: str, is_value: Callable[[str], bool]) -> list[str]:
    """Return `arguments` with `option=alone` in the place of each `option` without a value, up to `--`."""
    end = arguments.index("--") if "--" in arguments else len(arguments)
    followers = [*arguments, ""][1:]
    inserted = [
        f"{option}={alone}" if each == option and not is_value(follower) else each
        for each, follower in zip(arguments, followers, strict=True)
    ]
    return inserted[:end] + arguments[end:]
