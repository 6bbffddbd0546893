from __future__ import annotations

import asyncio

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


def test_a_coroutine_function_is_run_and_its_result_is_the_exit_code() -> None:
    @click.command(cls=Verb)
    async def slow() -> int:
        await asyncio.sleep(0)
        return 3

    assert slow.main([], standalone_mode=False) == 3


def test_help_shows_only_present_names(shell: Shell) -> None:
    text = shell.output("plot", "--help")
    assert "--duration" in text
    assert "--for" not in text


@pytest.mark.parametrize("words", [(), ("topic",), ("topic", "echo")])
def test_help_is_a_word_too(shell: Shell, words: tuple[str, ...]) -> None:
    assert shell.output("help", *words) == shell.output(*words, "--help")
    assert shell.output("topic", "help", "echo") == shell.output("topic", "echo", "--help")


def test_help_has_headings(shell: Shell) -> None:
    lines = shell.output("--help").splitlines()
    assert lines.index("Boards:") < lines.index("  serve        Connect boards to the ROS graph.")
    assert lines.index("Sketches:") < lines.index("  new          Write a new sketch.")
    _, own, graph = shell.output("topic", "list", "--help").partition("\nROS graph:\n")
    assert own and "--master" in graph and "[NAMESPACE]" not in graph


def test_help_fits_a_narrow_terminal(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    before_examples = shell.output("doctor", "--help").partition("Examples:")[0].splitlines()
    assert max(map(len, before_examples)) <= 40
    assert "  --json" in before_examples
    assert "      Print one JSON object per line." in before_examples


def test_an_option_that_belongs_in_the_address_is_explained(shell: Shell) -> None:
    failure = shell.failure("serve", "/dev/ttyACM0", "--baud", "115200", code=2)
    assert failure.endswith('no option --baud; write it after the port: "/dev/ttyACM0?baud=115200"')
