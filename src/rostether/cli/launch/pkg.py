"""`rostether pkg`: creates, lists and finds packages, and replaces catkin's commands."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from rostether.cli.launch.builtin_nodes import BUILTIN_NODES
from rostether.cli.shell.completion import beginning
from rostether.cli.shell.option_group import add_flag
from rostether.cli.shell.output import json_option, warn, write_line, write_result
from rostether.cli.shell.verbs import verb, verb_group
from rostether.errors import ConfigError
from rostether.mechanisms.text import did_you_mean
from rostether.msgdef.definition_files import bundled_names, bundled_packages
from rostether.packages.executables import programs
from rostether.packages.locate import package_folders
from rostether.packages.search_path import OnDuplicate
from rostether.packages.workspace import read_contents

# The distribution whose protocols and definitions rostether implements.
_DISTRIBUTION = "noetic"

# Warnings about packages with the same name; more appear only if a whole workspace was copied.
MAX_WARNINGS = 3


def complete_package_folders(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the packages on disk or built in that begin with the typed text."""
    built_in = {package for package, _ in BUILTIN_NODES}
    return beginning({*package_folders(os.environ, Path.cwd()), *built_in}, incomplete)


def complete_programs(context: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the programs of the typed package that begin with the typed text."""
    package = context.params.get("package", "")
    found = {program for owner, program in BUILTIN_NODES if owner == package}
    if folder := package_folders(os.environ, Path.cwd()).get(package):
        found.update(each.name for each in programs(folder))
    return beginning(found, incomplete)


def packages_here() -> dict[str, Path]:
    """Return the folders of all packages that this command finds, and warn about duplicate names."""
    with warned_duplicates() as on_duplicate:
        return package_folders(os.environ, Path.cwd(), on_duplicate=on_duplicate)


@contextmanager
def warned_duplicates() -> Iterator[OnDuplicate]:
    """Yield a callback for packages with the same name, and print a warning for each at the end."""
    lines: list[str] = []

    def note(name: str, used: Path, other: Path) -> None:
        lines.append(
            f"WARNING: two packages have the name {name}: using {used}, ignoring {other}; rename "
            "one, or create a file CATKIN_IGNORE in its folder"
        )

    yield note
    for line in lines[:MAX_WARNINGS]:
        warn(line)
    if len(lines) > MAX_WARNINGS:
        warn(f"WARNING: {len(lines) - MAX_WARNINGS} more packages have duplicate names")


pkg = verb_group(
    "pkg",
    """Work with ROS packages: folders with a package.xml. They need not be built.

    They are found on ROS_PACKAGE_PATH, in the catkin workspace around this folder, and below it.
    """,
    {
        "create": ("catkin:create", "Write a new package, like catkin_create_pkg."),
        "list": ("pkg:list_packages", "List packages and their folders."),
        "find": ("pkg:find", "Print a package's folder."),
        "list-names": ("pkg:list_names", "List the names of packages."),
        "depends1": ("pkg:depends1", "List the direct dependencies of a package."),
        "version": ("pkg:version", "Print a package's version, like rosversion."),
        "init-workspace": (
            "catkin:init",
            "Mark a folder as a workspace's src, like catkin_init_workspace.",
        ),
        "make": ("catkin:make", "Check a workspace and list its contents, without a build."),
    },
    """
    rostether pkg create my_robot std_msgs rospy
    rostether pkg list
    cd "$(rostether pkg find my_robot)"
    """,
    package="rostether.cli.launch",
)


def folder_of(name: str) -> Path:
    """Return a package's folder. Raises ConfigError with similar names."""
    packages = packages_here()
    if name not in packages:
        if any(owner == name for owner, _ in BUILTIN_NODES):
            raise ConfigError(f"package {name} is built in and has no folder; `rosrun {name}` runs its nodes")
        if name in bundled_packages():
            kind = "msg" if bundled_names(name, "msg") else "srv"
            shows = f"`rostether {kind} package {name}` lists its types"
            raise ConfigError(f"package {name} is built in and has no folder; {shows}")
        hint = (
            did_you_mean(name, {*packages, *bundled_packages()}) or "`rostether pkg list` shows those found"
        )
        raise ConfigError(
            f"no package {name} on ROS_PACKAGE_PATH, in the workspace around this folder or below it; {hint}"
        )
    return packages[name]


@verb("list", "rostether pkg list\nrostether pkg list --json")
@json_option
def list_packages(as_json: bool) -> None:
    """List all packages that are found from this folder, with their folders."""
    for name, folder in sorted(packages_here().items()):
        write_result({"package": name, "folder": str(folder)}, f"{name} {folder}", as_json=as_json)


@verb("list-names", "rostether pkg list-names")
def list_names() -> None:
    """List the names of all packages that are found from this folder."""
    for name in sorted(packages_here()):
        write_line(name)


@verb("find", "rostether pkg find mearm_model")
@click.argument("name", metavar="PACKAGE", shell_complete=complete_package_folders)
def find(name: str) -> None:
    """Print the folder of a package."""
    write_line(str(folder_of(name)))


@verb("depends1", "rostether pkg depends1 mearm_model")
@click.argument("name", metavar="PACKAGE")
def depends1(name: str) -> None:
    """List the direct dependencies in a package's package.xml."""
    for each in sorted(read_contents(folder_of(name)).description.dependencies):
        write_line(each)


@verb("version", "rostether pkg version mearm_model\nrostether pkg version -d")
@add_flag("-d --distro", "Print the name of the ROS distribution that rostether is compatible with.")
@click.argument("name", metavar="PACKAGE", required=False)
def version(distro: bool, name: str | None) -> None:
    """Print the version in a package's package.xml."""
    if distro or name is None:
        if not distro:
            raise click.UsageError("give a package, or -d for the distribution")
        write_line(os.environ.get("ROS_DISTRO") or _DISTRIBUTION)
        return
    write_line(read_contents(folder_of(name)).description.version)
