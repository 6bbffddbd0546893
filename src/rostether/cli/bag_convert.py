"""`rostether bag convert`: recordings from one format to the other, or compressed anew."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.output import warn, write_line
from rostether.cli.verbs import Verb


@click.command(
    "convert",
    cls=Verb,
    examples="""
    rostether bag convert drive.bag drive.mcap
    rostether bag convert drive.mcap drive.bag
    rostether bag convert drive.bag smaller.bag --compression bz2
    """,
)
@click.argument("source", type=click.Path(path_type=Path, dir_okay=False))
@click.argument("target", type=click.Path(path_type=Path, dir_okay=False))
@click.option(
    "--compression",
    type=click.Choice(["none", "bz2", "lz4"]),
    default="none",
    help="How chunks are packed (none).",
)
def bag_convert(source: Path, target: Path, compression: str) -> None:
    """Write the messages of SOURCE to TARGET, byte for byte, with their times, topics and types.

    The names of the files say which formats: .bag or .mcap.
    """
    from rostether.recording.files import open_recording
    from rostether.recording.reindexing import copy, refuse_same

    refuse_same(source, target)
    reader = open_recording(source)
    try:
        if reader.damage:
            warn(f"{source}: {reader.damage}; what is whole is taken")
        count = copy(reader, target, compression=compression)
    finally:
        reader.close()
    write_line(f"{target}: {count} messages")
