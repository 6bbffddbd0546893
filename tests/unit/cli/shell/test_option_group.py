from __future__ import annotations

from dataclasses import dataclass

import click
import pytest

from rostether.cli.shell.option_group import (
    NumberRange,
    add_flag,
    add_option,
    insert_value,
    option_group,
    option_sections,
)


@dataclass(frozen=True)
class Host:
    host: str | None = None


def test_an_option_without_a_value_gets_one() -> None:
    assert insert_value([], "--to", "here", str.isdigit) == []
    assert insert_value(["--to"], "--to", "here", str.isdigit) == ["--to=here"]
    assert insert_value(["--to", "5"], "--to", "here", str.isdigit) == ["--to", "5"]
    assert insert_value(["--to", "x"], "--to", "here", str.isdigit) == ["--to=here", "x"]
    assert insert_value(["--", "--to"], "--to", "here", str.isdigit) == ["--", "--to"]


def test_nan_is_in_no_range() -> None:
    assert NumberRange(0, 1).convert("0.5", None, None) == 0.5
    with pytest.raises(click.BadParameter, match="'nan' is not a number"):
        NumberRange(0, 1).convert("nan", None, None)


def test_the_help_has_options_by_heading() -> None:
    @click.command()
    @option_group("net", Host, [add_option("--host NAME", "Where.")], heading="Network")
    @add_flag("--fast", "Hurry.")
    @add_option("--slow", "Wait.", heading="Network")
    @click.argument("file")
    def command(file: str, net: Host, fast: bool, slow: str) -> None: ...

    sections = option_sections(command, click.Context(command))
    assert {heading: [text for _, text in records] for heading, records in sections.items()} == {
        "Options": ["Hurry.", "Show this message and exit."],
        "Network": ["Where.", "Wait."],
    }
