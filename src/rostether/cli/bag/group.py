"""`rostether bag`: record, play, show, check and repair recordings."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_VERBS = {
    "record": VerbEntry("rostether.cli.bag.record:bag_record", "Record topics into a file."),
    "play": VerbEntry("rostether.cli.bag.play:bag_play", "Replay recordings into the graph."),
    "info": VerbEntry("rostether.cli.bag.info:bag_info", "Show the contents of a recording."),
    "check": VerbEntry("rostether.cli.bag.check:bag_check", "Check a recording for errors."),
    "filter": VerbEntry("rostether.cli.bag.filter:bag_filter", "Keep the messages that match an expression."),
    "cut": VerbEntry("rostether.cli.bag.cut:bag_cut", "Keep what was recorded at a time."),
    "convert": VerbEntry("rostether.cli.bag.convert:bag_convert", "Convert between formats."),
    "compress": VerbEntry("rostether.cli.bag.repack:bag_compress", "Compress recordings."),
    "decompress": VerbEntry("rostether.cli.bag.repack:bag_decompress", "Decompress recordings."),
    "reindex": VerbEntry("rostether.cli.bag.reindex:bag_reindex", "Repair recordings that were not closed."),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether bag record --all -O drive.bag
    rostether bag info drive.bag
    rostether bag play drive.bag --rate 2
    """,
)
def bag() -> None:
    """Record and replay topics, in ROS 1 .bag files, MCAP files and ROS 2 bags.

    Files end with .bag, .mcap or .db3; a ROS 2 bag is a folder. LZ4 and Zstandard come with
    `pip install 'rostether[recording]'`.
    """
