"""`rostether pkg create`: a new package, with the options of catkin_create_pkg."""

from __future__ import annotations

import getpass
from pathlib import Path

import click
from msgspec.structs import replace

from rostether.cli.shell.option_group import add_flag, add_option, ignored_options, option_group
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.verbs import verb
from rostether.packages.create import NewPackage, create_package

_package_options = option_group(
    "package",
    NewPackage,
    (
        click.argument("name"),
        click.argument("dependencies", nargs=-1, metavar="[DEPENDENCY]..."),
        add_flag(
            "--meta is_metapackage", "Create a metapackage: only a name for the packages it depends on."
        ),
        add_option(
            "-s --sys-deps system_dependencies",
            "A system package to depend on; may be repeated.",
            multiple=True,
        ),
        add_option(
            "-b --boost-comps boost_components", "A Boost library to use; may be repeated.", multiple=True
        ),
        add_option("-V --pkg_version version", "The version (default: 0.0.0).", default="0.0.0"),
        add_option("-D --description", "The description.", default=""),
        add_option("-l --license licenses", "A license; may be repeated.", multiple=True),
        add_option("-a --author authors", "An author; may be repeated.", multiple=True),
        add_option("-m --maintainer maintainers", "A maintainer; may be repeated.", multiple=True),
    ),
)


@verb(
    "create",
    """
    rostether pkg create mearm_model std_msgs rospy roscpp
    rostether pkg create my_robot rospy -V 0.1.0 -D "My robot" -l Apache-2.0 -m "Ada <ada@example.org>"
    """,
)
@_package_options
@ignored_options("--rosdistro")
@json_option
def create(package: NewPackage, as_json: bool) -> None:
    """Write package.xml and CMakeLists.txt of a new package into a folder with its name."""
    created = create_package(Path.cwd(), replace(package, user=_user()))
    for line in created.warnings:
        warn(line)
    if as_json:
        write_json({"folder": str(created.folder), "files": [str(each) for each in created.files]})
        return
    for file in created.files:
        write_line(f"Created file {file.relative_to(Path.cwd())}")
    for folder in created.folders:
        write_line(f"Created folder {folder.relative_to(Path.cwd())}")
    write_line(f"Successfully created files in {created.folder}. Please adjust the values in package.xml.")


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        # A container may run as a user without a name.
        return "user"
