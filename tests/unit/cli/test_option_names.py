"""Options of one meaning have one name in all commands."""

from __future__ import annotations

from collections.abc import Iterator

import click

from rostether.cli.main import rostether
from rostether.cli.shell.verbs import Verb

# Former names of --duration, --output and --count.
# `firmware lib --for BOARD` has another meaning.
FORMER = {"--seconds", "--time", "--save", "--output-name", "--output-file", "--number", "--secs"}

# Short names of options; the exceptions have those of rosbag and rostopic.
LETTERS = {"--output": "-o", "--count": "-n"}
EXCEPTIONS = {("bag record", "--output"), ("bag record", "--count"), ("topic pub", "--count")}


def commands(command: click.Command, words: tuple[str, ...] = ()) -> Iterator[tuple[str, click.Command]]:
    if not isinstance(command, click.Group):
        yield " ".join(words), command
        return
    context = click.Context(command)
    for name in command.list_commands(context):
        below = command.get_command(context, name)
        assert below is not None
        yield from commands(below, (*words, name))


def test_options_of_one_meaning_have_one_name() -> None:
    verbs = dict(commands(rostether))
    assert len(verbs) > 80
    wrong = []
    for verb, command in verbs.items():
        for option in command.params:
            if not isinstance(option, click.Option) or option.hidden:
                continue
            wrong += [f"{verb} {each}" for each in option.opts if each in FORMER]
            wrong += [
                f"{verb} {name} without {letter}"
                for name, letter in LETTERS.items()
                if name in option.opts and letter not in option.opts and (verb, name) not in EXCEPTIONS
            ]
            # An output file needs its long name; only addresses of masters are called URI.
            if option.opts == ["-o"] or (option.metavar == "URI" and "--master" not in option.opts):
                wrong.append(f"{verb} {option.opts}")
    assert wrong == []


def test_former_names_stay_accepted() -> None:
    former = 0
    for verb, command in commands(rostether):
        if isinstance(command, Verb):
            names = {name for option in command.params for name in option.opts}
            assert set(command.old_options.values()) <= names, verb
            assert names.isdisjoint(command.old_options), verb
            former += len(command.old_options)
    assert former >= 10
