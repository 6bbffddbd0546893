"""`rostether xacro`: expand a xacro file, typed as for xacro."""

from __future__ import annotations

import os
from pathlib import Path

import click

from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import Verb


@click.command(
    "xacro",
    cls=Verb,
    examples="""
    rostether xacro robot.urdf.xacro
    rostether xacro robot.urdf.xacro gripper:=true -o robot.urdf
    rostether xacro --deps robot.urdf.xacro
    """,
)
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("mappings", nargs=-1, metavar="[ARGUMENT:=VALUE...]")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), metavar="FILE", help="Write the URDF to this file."
)
@click.option("--deps", is_flag=True, help="Print the included files instead.")
@click.option(
    "--inorder", "-i", is_flag=True, expose_value=False, help="Accepted for compatibility; has no effect."
)
@click.option("-q", "quiet", is_flag=True, expose_value=False, help="Accepted.")
def xacro(file: Path, mappings: tuple[str, ...], output: Path | None, deps: bool) -> None:
    """Expand FILE and print the URDF."""
    from rostether.errors import ConfigError
    from rostether.packages.locate import package_folders
    from rostether.robot.xacro import expand_xacro, parse_mappings, xacro_dependencies

    packages = package_folders(os.environ, Path.cwd())
    arguments = parse_mappings(mappings)
    if deps:
        write_line(" ".join(xacro_dependencies(file, arguments, packages=packages)))
        return
    text = expand_xacro(file, arguments, packages=packages)
    if output is None:
        write_line(text)
        return
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{output}: {error.strerror}; choose another file") from error
