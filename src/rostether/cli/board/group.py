"""`rostether board`: simulated boards."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_VERBS = {
    "run": VerbEntry(
        "rostether.cli.board.run:board_run", "Run a sketch or an ELF file on a simulated board."
    ),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether board run blink.ino --watch D13
    """,
)
def board() -> None:
    """Run real AVR firmware on simulated boards."""
