"""`rostether bag compress`, `decompress` and `reindex`: rewrite recordings in place."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any, TypeVar

import click

from rostether.cli.bag.figures import size_text
from rostether.cli.shell.option_group import PATH
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import Verb
from rostether.errors import ConfigError

Function = TypeVar("Function", bound=Callable[..., Any])


def place_options(function: Function) -> Function:
    """Add --output-dir, --force and --quiet."""
    for option in (
        click.option("-q", "--quiet", is_flag=True, help="Print only errors."),
        click.option("-f", "--force", is_flag=True, help="Overwrite an older NAME.orig.bag."),
        click.option(
            "--output-dir",
            metavar="DIR",
            type=click.Path(path_type=Path, file_okay=False),
            help="Write to DIR instead.",
        ),
    ):
        function = option(function)
    return function


def new_place(path: Path, output_dir: Path | None, *, force: bool) -> tuple[Path, Path | None]:
    """Return the path of the new recording, and that of the old one if it is moved. Raises ConfigError."""
    name = path.name.removesuffix(".active")
    if output_dir is not None:
        try:
            output_dir.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigError(
                f"cannot create the folder {output_dir}: {error.strerror or error}; choose another folder"
            ) from None
        return output_dir / name, None
    output = path.parent / name
    stem, _, suffix = name.rpartition(".")
    backup = path.with_name(f"{name}.orig" if path.is_dir() else f"{stem}.orig.{suffix}")
    if backup.exists() and not force:
        raise ConfigError(f"{backup} already exists; -f overwrites it")
    if output != path and output.exists():
        raise ConfigError(f"{output} already exists, so {path} cannot be written there; use --output-dir")
    return output, backup


@click.command(
    "compress",
    cls=Verb,
    examples="""
    rostether bag compress drive.bag
    rostether bag compress --lz4 --output-dir small *.bag
    """,
)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=PATH)
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
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=PATH)
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


@click.command(
    "reindex",
    cls=Verb,
    examples="""
    rostether bag reindex drive.bag.active
    rostether bag reindex --output-dir repaired *.bag
    """,
)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=PATH)
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
            what = f"{mended.message_count} messages"
            if not mended.damage:
                write_line(f"{output}: {what}, complete, not changed")
                continue
            if mended.listed_count is not None:
                what = f"{mended.message_count} of {mended.listed_count} messages"
            write_line(f"{output}: {what} kept ({mended.damage})")
