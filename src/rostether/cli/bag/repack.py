"""`rostether bag compress` and `decompress`: rewrite recordings in place."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import click

from rostether.cli.bag.figures import size_text
from rostether.cli.bag.places import new_place, place_options
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import Verb


@click.command(
    "compress",
    cls=Verb,
    examples="""
    rostether bag compress drive.bag
    rostether bag compress --lz4 --output-dir small *.bag
    """,
)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))
@click.option("-j", "--bz2", is_flag=True, help="Use bz2 (the default for .bag files).")
@click.option("--lz4", is_flag=True, help="Use LZ4: larger, but much faster to read.")
@place_options
def bag_compress(
    files: tuple[Path, ...], bz2: bool, lz4: bool, output_dir: Path | None, force: bool, quiet: bool
) -> None:
    """Compress recordings with bz2 or LZ4. The original file is kept as NAME.orig.bag."""
    if bz2 and lz4:
        raise click.UsageError("give --bz2 or --lz4, not both")
    for path in files:
        # MCAP has no bz2.
        is_lz4 = lz4 or (not bz2 and path.suffix != ".bag")
        _repack(path, "lz4" if is_lz4 else "bz2", output_dir, force=force, quiet=quiet)


@click.command(
    "decompress",
    cls=Verb,
    examples="""
    rostether bag decompress drive.bag
    """,
)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))
@place_options
def bag_decompress(files: tuple[Path, ...], output_dir: Path | None, force: bool, quiet: bool) -> None:
    """Decompress recordings. The original file is kept as NAME.orig.bag."""
    for path in files:
        _repack(path, "none", output_dir, force=force, quiet=quiet)


def _repack(path: Path, compression: str, output_dir: Path | None, *, force: bool, quiet: bool) -> None:
    from rostether.recording.reindexing import repack

    before = _size_bytes(path)  # and no folder is created for a file that is not a recording
    output, backup = new_place(path, output_dir, force=force)
    count = repack(path, output, compression, keep_original=backup)
    if not quiet:
        sizes = f"{size_text(before)} before, {size_text(_size_bytes(output))} now"
        write_line(f"{output}: {count} messages, {sizes}")


def _size_bytes(path: Path) -> int:
    from rostether.recording.files import open_recording

    with closing(open_recording(path)) as reader:
        return reader.size_bytes
