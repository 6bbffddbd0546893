from __future__ import annotations

import click
import pytest

from rostether.cli.shell.option_group import NumberRange, insert_value


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
