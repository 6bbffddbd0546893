"""`rostether completion`: prints the shell code that completes rostether's commands."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

import click
from click.shell_completion import get_completion_class

from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import verb

SHELLS = ("bash", "zsh", "fish")

_PROGRAM = "rostether"
# The shell code asks rostether for completions with this variable; its name follows click's rule.
_VARIABLE = "_ROSTETHER_COMPLETE"
# Characters that no shell replaces; at the beginning, `~` is the home folder, and in zsh `=` a command.
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
    completion_class = get_completion_class(name)
    assert completion_class is not None
    shell_code = completion_class(click.Command(_PROGRAM), {}, _PROGRAM, _VARIABLE)
    # Its method `source` would also start bash to check its version, which is slow.
    text = shell_code.source_template % shell_code.source_vars()
    # Otherwise, fish cuts descriptions at their first comma.
    write_line(text.replace('string split ","', 'string split --max 1 ","').strip())


def beginning(names: Iterable[str], typed: str) -> list[str]:
    """Return the names that begin with the typed text, which may omit the first slash, sorted.

    Shells insert a completed word unchanged, and a peer may name its node `$(command)`. Therefore words with
    characters that a shell would replace are omitted.
    """
    return sorted(name for name in names if name.startswith((typed, f"/{typed}")) and _PLAIN.fullmatch(name))
