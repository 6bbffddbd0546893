"""`rostether link`: records, shows and replays the bytes on a board's line."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_VERBS = {
    "record": VerbEntry("rostether.cli.link.record:link_record", "Serve a board and record its line."),
    "show": VerbEntry("rostether.cli.link.show:link_show", "List the frames of a capture."),
    "replay": VerbEntry(
        "rostether.cli.link.replay:link_replay",
        "Replay a capture into the graph as if its board were connected.",
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
    """Record, show and replay the bytes on a board's line.

    A capture contains the bytes of the board and of the host, with times. Use it to show a problem without
    the board.
    """
