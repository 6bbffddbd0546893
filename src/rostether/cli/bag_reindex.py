"""`rostether bag reindex`: recordings that were not closed, mended."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.output import write_line
from rostether.cli.verbs import Verb
from rostether.errors import ConfigError


@click.command(
    "reindex",
    cls=Verb,
    examples="""
    rostether bag reindex drive.bag.active
    rostether bag reindex --output-dir mended *.bag
    """,
)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))
@click.option(
    "--output-dir",
    metavar="DIR",
    type=click.Path(path_type=Path, file_okay=False),
    help="Write to DIR instead.",
)
@click.option("-f", "--force", is_flag=True, help="Write over an older NAME.orig.bag.")
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but what goes wrong.")
def bag_reindex(files: tuple[Path, ...], output_dir: Path | None, force: bool, quiet: bool) -> None:
    """Keep all that is whole in recordings that a kill, a full disk or a bad copy left without their end.

    The file as it was stays beside it as NAME.orig.bag. NAME.bag.active becomes NAME.bag. Recordings that are
    whole are left alone.
    """
    from rostether.recording.reindexing import reindex

    for path in files:
        name = path.name.removesuffix(".active")
        output = (output_dir or path.parent) / name
        backup = None
        if output_dir is None:
            stem, _, suffix = name.rpartition(".")
            backup = path.with_name(f"{name}.orig" if path.is_dir() else f"{stem}.orig.{suffix}")
            if backup.exists() and not force:
                raise ConfigError(f"{backup} exists; -f writes over it")
            if output != path and output.exists():
                raise ConfigError(f"{output} exists, and {path} is to become it; take --output-dir")
        else:
            output_dir.mkdir(parents=True, exist_ok=True)
        mended = reindex(path, output, keep_original=backup)
        if not quiet:
            why = f" ({mended.damage})" if mended.damage else ""
            what = f"{mended.message_count} messages"
            write_line(f"{output}: {what} kept{why}" if why else f"{output}: {what}, whole as it was")
