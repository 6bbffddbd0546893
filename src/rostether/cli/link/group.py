"""`rostether link`: what goes over a board's line, recorded, shown and played again."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_VERBS = {
    "record": VerbEntry("rostether.cli.link.record:link_record", "Serve a board and record its line."),
    "show": VerbEntry("rostether.cli.link.show:link_show", "List the frames of a capture."),
    "replay": VerbEntry(
        "rostether.cli.link.replay:link_replay", "Play a capture into the graph as if its board were there."
    ),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether link record /dev/ttyACM0 problem.jsonl
    rostether link show problem.jsonl
    rostether link replay problem.jsonl
    """,
)
def link() -> None:
    """Record what goes over a board's line, byte for byte, look at it, and play it again.

    A capture holds the board's bytes and the host's with their times; it is how to show somebody a problem
    without the board.
    """
