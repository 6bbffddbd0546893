"""Groups of options: added to a verb in one step and passed to it as one value.

A settings class declares each of its options once, as a field:

    @dataclass(frozen=True, slots=True)
    class EchoOptions:
        count: int | None = option("-n --count COUNT", "Stop after COUNT messages.", type=COUNT)
        once: bool = flag("--once", "Stop after one message.")

    @verb("echo", "rostether topic echo /ultrasound")
    @option_group("options", EchoOptions)
    @add_flag("-v --verbose", "Show more.")
    def echo(options: EchoOptions, verbose: bool) -> None: ...

The first text of an option is what its help shows.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, Final, TypeVar

import click

Function = TypeVar("Function", bound=Callable[..., Any])
Decorator = Callable[[Any], Any]
_UNITS_S: Final = {"": 1, "s": 1, "m": 60, "h": 3600}


class NumberRange(click.FloatRange):
    """A range of numbers without `nan`, which for click is in every range."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number."""
        number: float = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value!r} is not a number", param, ctx)
        return number


class _DurationType(click.ParamType[float]):
    """A duration such as 30, 30s, 5m or 2h."""

    name = "duration"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, float):
            return value
        match = re.fullmatch(r"(\d+(?:\.\d+)?)([smh]?)", str(value))
        if match is None or not float(match[1]):
            self.fail(f"{value!r} is not a duration; write 30, 30s, 5m or 2h", param, ctx)
        return float(match[1]) * _UNITS_S[match[2]]


POSITIVE: Final = NumberRange(min=0, min_open=True)
NOT_NEGATIVE: Final = NumberRange(min=0)
DURATION: Final = _DurationType()
COUNT: Final = click.IntRange(min=1)
PORT: Final = click.IntRange(1, 65535)
PATH: Final[click.Path] = click.Path(path_type=Path)
FILE: Final[click.Path] = click.Path(path_type=Path, dir_okay=False)
EXISTING_FILE: Final[click.Path] = click.Path(path_type=Path, dir_okay=False, exists=True)

_DECORATOR: Final = "decorator"
DEFAULT_HEADING: Final = "Options"


class HeadedOption(click.Option):
    """An option with its heading in the help."""

    def __init__(self, *args: Any, heading: str = DEFAULT_HEADING, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.heading = heading


def add_option(spellings: str, text: str, **settings: Any) -> Decorator:
    """Return a decorator that adds an option to a verb.

    Args:
        spellings: `"-o --output folder DIR"`: the option; the name of the verb's parameter, if it differs;
            and the name of the value, in capitals.
        text: The line in the help.
        settings: More arguments of `click.option`.
    """
    return _option(spellings, (), text, settings)


def _option(spellings: str, name: tuple[str, ...], text: str, settings: dict[str, Any]) -> Decorator:
    *words, last = spellings.split()
    if last.isupper() and not last.startswith("-"):
        settings = {"metavar": last, **settings}
    else:
        words.append(last)
    return click.option(*words, *name, help=text, **{"cls": HeadedOption, **settings})


def add_flag(spellings: str, text: str, **settings: Any) -> Decorator:
    """Return a decorator that adds an option without a value to a verb."""
    return add_option(spellings, text, is_flag=True, **settings)


def option(spellings: str, text: str, *, default: Any = None, **settings: Any) -> Any:
    """Return a field of a settings class that is an option; its name is the field's, see `add_option`.

    `default` is the value without the option; an option with `multiple` has an empty tuple.
    """
    if settings.get("multiple"):
        default = ()
    else:
        settings["default"] = default
    return dataclasses.field(
        default=default, metadata={_DECORATOR: lambda name: _option(spellings, (name,), text, settings)}
    )


def flag(spellings: str, text: str) -> Any:
    """Return a field of a settings class that is an option without a value."""
    return option(spellings, text, default=False, is_flag=True)


def argument(*, default: Any = None, **settings: Any) -> Any:
    """Return a field of a settings class that is an argument; `settings` are those of `click.argument`."""
    if default is not None:
        settings["default"] = default
    if settings.get("nargs") == -1:
        default = ()
    return dataclasses.field(
        default=default, metadata={_DECORATOR: lambda name: click.argument(name, **settings)}
    )


def shared(decorator: Decorator, default: Any) -> Any:
    """Return a field of a settings class for an option of many verbs; the option has the field's name."""
    return dataclasses.field(default=default, metadata={_DECORATOR: lambda _: decorator})


def option_group(
    name: str, build: Callable[..., object], options: Sequence[Decorator] = (), *, heading: str = ""
) -> Callable[[Function], Function]:
    """Return a decorator that adds click options to a verb; the help shows them under the heading.

    The verb gets one argument `name`, the value that `build` returns. The parameters of `build` have the
    names of the options. A parameter without an option keeps its default, and the arguments that a `partial`
    sets have no option. A settings class declares its own options.
    """
    parameters = inspect.signature(build).parameters.keys() - getattr(build, "keywords", {}).keys()
    if dataclasses.is_dataclass(build):
        own = (each.metadata[_DECORATOR](each.name) for each in dataclasses.fields(build) if each.metadata)
        options = (*own, *options)

    def decorate(function: Function) -> Function:
        @wraps(function)
        def with_value(*args: Any, **kwargs: Any) -> Any:
            typed = {each: kwargs.pop(each) for each in parameters if each in kwargs}
            return function(*args, **{name: build(**typed)}, **kwargs)

        decorated: Any = with_value
        others = len(getattr(decorated, "__click_params__", ()))
        for each in reversed(options):
            decorated = each(decorated)
        if heading:
            for parameter in getattr(decorated, "__click_params__", ())[others:]:
                parameter.heading = heading
        return decorated  # type: ignore[no-any-return]

    return decorate


def option_sections(command: click.Command, context: click.Context) -> dict[str, list[tuple[str, str]]]:
    """Return the spelling and the text of each option that the help shows, by heading."""
    sections: dict[str, list[tuple[str, str]]] = {DEFAULT_HEADING: []}
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        # In some versions of click, arguments have a record too, without a text.
        if record is not None and record[1]:
            heading = parameter.heading if isinstance(parameter, HeadedOption) else DEFAULT_HEADING
            sections.setdefault(heading, []).append(record)
    return {heading: records for heading, records in sections.items() if records}


def ignored_options(*names: str, flags: Sequence[str] = ()) -> Callable[[Function], Function]:
    """Return a decorator that accepts options of other programs and ignores them.

    Args:
        names: Options with a value, such as `"--spin-time"`; spaces separate spellings of one option.
        flags: Options without a value, such as `"-l --long"`.
    """

    def decorate(function: Function) -> Function:
        decorated: Any = function
        for spellings in (*names, *flags):
            decorated = click.option(
                *spellings.split(),
                # An argument may have the same name.
                f"ignored_{spellings.split()[0].strip('-').replace('-', '_')}",
                is_flag=spellings in flags,
                expose_value=False,
                hidden=True,
            )(decorated)
        return decorated  # type: ignore[no-any-return]

    return decorate


class OptionalValueOption(HeadedOption):
    """An option whose value may be omitted; the option then has the value `alone`.

    `is_value` returns whether the next word of the command line is the option's value.
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
