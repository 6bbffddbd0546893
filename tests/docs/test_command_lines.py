"""Parses every rostether command of the pages and of the examples' comments, also those that no test runs."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from rostether.cli.main import rostether, split_special
from rostether.msgdef.registry import Registry

REPOSITORY = Path(__file__).parents[2]
_COMMANDS = re.compile(r"^```sh[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
# Several commands, or a command and its explanation, may be in one line of a comment.
_IN_COMMENT = re.compile(r"^(?://|#) *(?:Try it:)? +(rostether .*)", re.MULTILINE)


def command_lines() -> Iterator[tuple[str, str]]:
    """Yield the commands after the word rostether, each with its file."""
    for page in (REPOSITORY / "README.md", *sorted((REPOSITORY / "docs").rglob("*.md"))):
        for block in _COMMANDS.findall(page.read_text()):
            for line in block.replace("\\\n", " ").splitlines():
                for found in re.findall(r"(?:^|\s|/)rostether ([a-z][^|]*?)(?: \|.*| 2>.*|\)\"?)?$", line):
                    # pipx has commands with the name of the package.
                    if not line.startswith("pipx "):
                        yield page.name, found
    for source in sorted((REPOSITORY / "client").rglob("examples/**/*.*")):
        for line in _IN_COMMENT.findall(source.read_text()):
            for part in re.split(r" {4,}", line):
                if part.startswith("rostether "):
                    yield source.name, part.removeprefix("rostether ")


LINES = list(command_lines())


@pytest.mark.parametrize(("file", "line"), LINES, ids=[f"{file}: {line}" for file, line in LINES])
def test_the_command_has_these_options_and_arguments(file: str, line: str) -> None:
    words, _ = split_special(shlex.split(line, comments=True))
    if "--help" in words:
        return
    command: click.Command = rostether
    context = click.Context(command)
    while isinstance(command, click.Group):
        name, found, words = command.resolve_command(context, words)
        assert name is not None
        assert found is not None
        context = click.Context(found, info_name=name, parent=context)
        command = found
    try:
        parsed = command.make_context(command.name, words, parent=context.parent).params
    except click.BadParameter as error:
        # Readers have these files.
        if "does not exist" not in error.message:
            raise
        return
    if command.name == "pub" and not parsed["values"]:
        assert not Registry.from_environment().message(parsed["type_name"]).fields, "its type needs values"


def test_there_are_commands() -> None:
    assert len(LINES) > 300
