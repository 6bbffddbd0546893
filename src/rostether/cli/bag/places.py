"""Where recordings go that are written anew in their own place: the old one stays beside them."""

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
        click.option("-q", "--quiet", is_flag=True, help="Say nothing but what goes wrong."),
        click.option("-f", "--force", is_flag=True, help="Write over an older NAME.orig.bag."),
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
    """Return where the new recording goes, and where the old one, if it must give way. Raises ConfigError."""
    name = path.name.removesuffix(".active")
    if output_dir is not None:
        try:
            output_dir.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigError(
                f"cannot make the folder {output_dir}: {error.strerror or error}; name one of yours"
            ) from None
        return output_dir / name, None
    output = path.parent / name
    stem, _, suffix = name.rpartition(".")
    backup = path.with_name(f"{name}.orig" if path.is_dir() else f"{stem}.orig.{suffix}")
    if backup.exists() and not force:
        raise ConfigError(f"{backup} exists; -f writes over it")
    if output != path and output.exists():
        raise ConfigError(f"{output} exists, and {path} is to become it; take --output-dir")
    return output, backup
