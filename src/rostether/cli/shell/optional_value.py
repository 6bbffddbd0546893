"""Options whose value may be left out: `--ros2` and `--ros2 zenoh`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click


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
