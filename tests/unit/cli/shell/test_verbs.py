from __future__ import annotations

import click
import pytest

from rostether.cli.shell.verbs import Verb
from unit.cli.command_shell import Shell


@click.command(cls=Verb, old_options={"--for": "--duration"})
@click.option("--duration", type=int)
@click.argument("words", nargs=-1)
def example(duration: int | None, words: tuple[str, ...]) -> None:
    click.echo(f"{duration} {' '.join(words)}")


@pytest.mark.parametrize(
    ("typed", "printed"),
    [
        (["--duration", "3"], "3 "),
        (["--for", "3"], "3 "),
        (["--for=3", "a"], "3 a"),
        (["--duration", "3", "--", "--for"], "3 --for"),
    ],
)
def test_former_names_of_options_stay_accepted(
    typed: list[str], printed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    example.main(typed, standalone_mode=False)
    assert capsys.readouterr().out == f"{printed}\n"


def test_help_shows_only_present_names(shell: Shell) -> None:
    text = shell.output("plot", "--help")
    assert "--duration" in text
    assert "--for" not in text


@pytest.mark.parametrize("words", [(), ("topic",), ("topic", "echo")])
def test_help_is_a_word_too(shell: Shell, words: tuple[str, ...]) -> None:
    assert shell.output("help", *words) == shell.output(*words, "--help")
    assert shell.output("topic", "help", "echo") == shell.output("topic", "echo", "--help")
