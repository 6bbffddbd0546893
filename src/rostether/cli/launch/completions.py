"""Shell completion of packages and their programs."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.launch.served_nodes import served_nodes


def complete_package_folders(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the packages on disk or built in that begin with the typed text."""
    ours = {package for package, _ in served_nodes()}
    return [name for name in sorted({*_packages_here(), *ours}) if name.startswith(incomplete)]


def complete_programs(context: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the programs of the typed package that begin with the typed text."""
    from rostether.packages.executables import programs

    package = context.params.get("package", "")
    found = {kind for role, kind in served_nodes() if role == package}
    if folder := _packages_here().get(package):
        found.update(each.name for each in programs(folder))
    return [name for name in sorted(found) if name.startswith(incomplete)]


def _packages_here() -> dict[str, Path]:
    import os

    from rostether.packages.locate import package_folders

    return package_folders(os.environ, Path.cwd())
