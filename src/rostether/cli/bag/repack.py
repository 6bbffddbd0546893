"""`rostether bag compress`, `decompress` and `reindex`: rewrite recordings in place."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import click

from rostether.cli.bag.formatting import size_text
from rostether.cli.bag.recording_files import create_folder
from rostether.cli.shell.interrupts import cleaning_up
from rostether.cli.shell.option_group import PATH, add_flag, argument, flag, option, option_group
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.text import counted


@dataclass(frozen=True, slots=True)
class RepackOptions:
    """The files to rewrite, and the folder of the new ones."""

    files: tuple[Path, ...] = argument(nargs=-1, required=True, metavar="FILE...", type=PATH)
    output_dir: Path | None = option(
        "--output-dir DIR", "Write to DIR instead.", type=click.Path(path_type=Path, file_okay=False)
    )
    force: bool = flag("-f --force", "Overwrite an older NAME.orig.bag.")
    quiet: bool = flag("-q --quiet", "Print only errors.")


def new_paths(path: Path, options: RepackOptions) -> tuple[Path, Path | None]:
    """Return the path of the new recording and of the backup, None if the old one is not moved.

    Raises ConfigError.
    """
    name, output_dir = path.name.removesuffix(".active"), options.output_dir
    if output_dir is not None:
        create_folder(output_dir)
        return output_dir / name, None
    output = path.parent / name
    stem, _, suffix = name.rpartition(".")
    backup = path.with_name(f"{name}.orig" if path.is_dir() else f"{stem}.orig.{suffix}")
    if backup.exists() and not options.force:
        raise ConfigError(f"{backup} already exists; overwrite it with -f, or use --output-dir")
    if output != path and output.exists():
        raise ConfigError(f"{output} already exists, so {path} cannot be written there; use --output-dir")
    return output, backup


@verb(
    "compress",
    """
    rostether bag compress drive.bag
    rostether bag compress --lz4 --output-dir small *.bag
    """,
)
@add_flag("-j --bz2", "Use bz2 (the default for .bag files).")
@add_flag("--lz4", "Use LZ4: larger, but much faster to read.")
@option_group("options", RepackOptions)
@cleaning_up()
def bag_compress(options: RepackOptions, bz2: bool, lz4: bool) -> None:
    """Compress recordings with bz2 or LZ4. The original file is kept as NAME.orig.bag."""
    if bz2 and lz4:
        raise click.UsageError("give --bz2 or --lz4, not both")
    for path in options.files:
        # MCAP has no bz2.
        is_lz4 = lz4 or (not bz2 and path.suffix != ".bag")
        _repack(path, "lz4" if is_lz4 else "bz2", options)


@verb(
    "decompress",
    "rostether bag decompress drive.bag",
)
@option_group("options", RepackOptions)
@cleaning_up()
def bag_decompress(options: RepackOptions) -> None:
    """Decompress recordings. The original file is kept as NAME.orig.bag."""
    for path in options.files:
        _repack(path, "none", options)


def _repack(path: Path, compression: str, options: RepackOptions) -> None:
    from rostether.recording.reindexing import repack

    # Reading the size also rejects a file that is not a recording, before a folder is created.
    before = _size_bytes(path)
    output, backup = new_paths(path, options)
    count = repack(path, output, compression, keep_original=backup)
    if not options.quiet:
        sizes = f"{size_text(before)} before, {size_text(_size_bytes(output))} now"
        write_line(f"{output}: {counted(count, 'message')}, {sizes}")


def _size_bytes(path: Path) -> int:
    from rostether.recording.files import open_recording

    with closing(open_recording(path)) as reader:
        return reader.size_bytes


@verb(
    "reindex",
    """
    rostether bag reindex drive.bag.active
    rostether bag reindex --output-dir repaired *.bag
    """,
)
@option_group("options", RepackOptions)
@cleaning_up()
def bag_reindex(options: RepackOptions) -> None:
    """Repair recordings that are truncated or damaged: keep every complete message.

    The original file is kept as NAME.orig.bag. NAME.bag.active becomes NAME.bag. Complete recordings are not
    changed.
    """
    from rostether.recording.reindexing import reindex

    for path in options.files:
        output, backup = new_paths(path, options)
        repaired = reindex(path, output, keep_original=backup)
        if not options.quiet:
            what = counted(repaired.message_count, "message")
            if not repaired.damage:
                write_line(f"{output}: {what}, complete, not changed")
                continue
            if repaired.listed_count is not None:
                what = f"{repaired.message_count} of {counted(repaired.listed_count, 'message')}"
            write_line(f"{output}: {what} kept ({repaired.damage})")
