"""Chooses the paths for rewritten recordings: the old file stays beside the new one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

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
