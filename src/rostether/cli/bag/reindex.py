"""`rostether bag reindex`: repairs recordings that were not closed."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.bag.places import new_place, place_options
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import Verb


@click.command(
    "reindex",
    cls=Verb,
    examples="""
    rostether bag reindex drive.bag.active
    rostether bag reindex --output-dir repaired *.bag
    """,
)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))
@place_options
def bag_reindex(files: tuple[Path, ...], output_dir: Path | None, force: bool, quiet: bool) -> None:
    """Repair recordings that are truncated or damaged: keep every complete message.

    The original file is kept as NAME.orig.bag. NAME.bag.active becomes NAME.bag. Complete recordings are not
    changed.
    """
    from rostether.recording.reindexing import reindex

    for path in files:
        output, backup = new_place(path, output_dir, force=force)
        mended = reindex(path, output, keep_original=backup)
        if not quiet:
            why = f" ({mended.damage})" if mended.damage else ""
            what = f"{mended.message_count} messages"
            write_line(f"{output}: {what} kept{why}" if why else f"{output}: {what}, complete, not changed")
