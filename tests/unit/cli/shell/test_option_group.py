from __future__ import annotations

from rostether.cli.shell.option_group import insert_value


def test_an_option_without_a_value_gets_one() -> None:
    assert insert_value([], "--to", "here", str.isdigit) == []
    assert insert_value(["--to"], "--to", "here", str.isdigit) == ["--to=here"]
    assert insert_value(["--to", "5"], "--to", "here", str.isdigit) == ["--to", "5"]
    assert insert_value(["--to", "x"], "--to", "here", str.isdigit) == ["--to=here", "x"]
    assert insert_value(["--", "--to"], "--to", "here", str.isdigit) == ["--", "--to"]
