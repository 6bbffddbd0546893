"""`rostether bag convert`: converts recordings to another format or compression."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import click

from rostether.cli.access.options import msg_path_option
from rostether.cli.bag.recording_files import (
    asked_form,
    format_option,
    open_for,
    recording_types,
    storage_option,
    warn_of_damage,
)
from rostether.cli.shell.option_group import PATH, add_option
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.verbs import verb
from rostether.mechanisms.text import counted, misfit_text


@verb(
    "convert",
    """
    rostether bag convert drive.bag drive.mcap
    rostether bag convert drive.mcap drive.bag
    rostether bag convert drive.bag smaller.bag --compression bz2
    rostether bag convert drive.bag drive             a ROS 2 bag, a folder
    rostether bag convert rosbag2_2026_11_20 drive.bag
    """,
)
@click.argument("source", type=PATH)
@click.argument("target", type=PATH)
@add_option(
    "--compression",
    "The compression of chunks (default: none).",
    type=click.Choice(["none", "bz2", "lz4"]),
    default="none",
)
@format_option
@storage_option
@msg_path_option
def bag_convert(
    source: Path, target: Path, compression: str, form: str | None, storage: str, msg_paths: tuple[Path, ...]
) -> None:
    """Write the messages of SOURCE to TARGET, with their times, topics and types.

    The extensions .bag, .mcap and .db3 select the format; a name without one of them is a ROS 2 bag, a
    folder. Messages are copied byte for byte, and converted only between ROS 1 and ROS 2.
    """
    from rostether.recording.files import Form
    from rostether.recording.reindexing import copy, refuse_same

    refuse_same(source, target)
    reader, target_form = open_for(source, target, asked_form(form))
    with closing(reader):
        warn_of_damage(source, reader)
        # Only types that go from ROS 1 to ROS 2 must be known; the recordings contain all others.
        types = recording_types((), msg_paths) if msg_paths and target_form is Form.ROS2 else None
        count = copy(reader, target, compression=compression, form=target_form, storage=storage, types=types)
        unfit = sum(reader.counts.values()) - count
        if unfit and not reader.unreadable:
            warn(f"{source}: {misfit_text(unfit)}; `rostether bag check` shows which")
        for topic, why in reader.unreadable.items():
            warn(f"{source}: {topic} is not copied completely: {why}")
    write_line(f"{target}: {counted(count, 'message')}")
