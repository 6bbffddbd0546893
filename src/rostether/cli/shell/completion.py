"""`rostether completion`: prints the shell code that completes our commands."""

from __future__ import annotations

import os
import re
from pathlib import Path

import click
from click.shell_completion import get_completion_class

from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import verb

SHELLS = ("bash", "zsh", "fish")

_PROGRAM = "rostether"
_VARIABLE = "_ROSTETHER_COMPLETE"
_PLAIN = re.compile(r"[\w/.:@%+,-][\w/.:@%+,=~-]*")


@verb(
    "completion",
    """
    eval "$(rostether completion bash)"                   in this shell
    rostether completion bash >> ~/.bashrc                permanently
    rostether completion zsh >> ~/.zshrc
    rostether completion fish > ~/.config/fish/completions/rostether.fish
    """,
)
@click.argument("shell", required=False, type=click.Choice(SHELLS))
def completion(shell: str | None) -> None:
    """Print shell code that completes commands, options, topics, nodes and types.

    The default is the shell in $SHELL.
    """
    name = shell or Path(os.environ.get("SHELL", "")).name
    if name not in SHELLS:
        raise click.UsageError(f"give a shell: {', '.join(SHELLS)}")
    found = get_completion_class(name)
    assert found is not None
    writer = found(click.Command(_PROGRAM), {}, _PROGRAM, _VARIABLE)
    # `source` first checks the version of bash, which takes as long as starting it.
    write_line((writer.source_template % writer.source_vars()).strip())


def is_plain(word: str) -> bool:
    """Return whether a word means itself in every shell.

    Shells insert a completed word as it is, and any node or file can be called `$(command)`: only plain words
    may be offered.
    """
    return _PLAIN.fullmatch(word) is not None
