"""Replacements for catkin_create_pkg, catkin_init_workspace, catkin_make and make_libraries.py."""

from __future__ import annotations

import getpass
from collections.abc import Callable
from pathlib import Path

import click
from msgspec.structs import replace

from rostether.cli.firmware.lib import firmware_lib
from rostether.cli.shell.failures import EXIT_FAILED
from rostether.cli.shell.option_group import PATH, add_flag, add_option, ignored_options, option_group
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.verbs import Verb, verb
from rostether.errors import RostetherError
from rostether.mechanisms.text import counted
from rostether.msgdef.registry import Registry
from rostether.packages.create import NewPackage, create_package
from rostether.packages.executables import programs
from rostether.packages.locate import SOURCE_FOLDER, workspace_of
from rostether.packages.python_scripts import explain_python2
from rostether.packages.workspace import (
    PackageContents,
    broken_packages,
    init_workspace,
    read_workspace,
    write_setup_files,
)

# Options of catkin_make that are ignored, each with its value in the same word.
_CMAKE_OPTIONS = ("-D", "-G", "-j", "-l", "-W")
# Common targets, and their replacements.
_TARGETS = {
    "install": "no install folder is made; packages are used where they are",
    "run_tests": "no tests are built or run; run Python tests with pytest",
    "test": "no tests are built or run; run Python tests with pytest",
    "tests": "no tests are built or run; run Python tests with pytest",
    "clean": "nothing was built, so nothing is removed",
    "doxygen": "no documentation is built",
}


@verb("init-workspace", "cd ~/catkin_ws/src\nrostether pkg init-workspace")
@click.argument("folder", type=PATH, required=False)
def init(folder: Path | None) -> None:
    """Mark this folder, or the one given, as the src of a catkin workspace.

    Only a real catkin needs the mark; rostether finds packages without it.
    """
    write_line(f"Created file {init_workspace(folder or Path.cwd())}")


class _CatkinVerb(Verb):
    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        # Otherwise -DCMAKE_X=h is read as short options, and its h prints the help.
        return super().parse_args(ctx, [each for each in args if not each.startswith(_CMAKE_OPTIONS)])


@verb(
    "make",
    """
    cd ~/catkin_ws
    rostether pkg make
    source devel/setup.bash
    """,
    cls=_CatkinVerb,
    context_settings={"ignore_unknown_options": True},
)
@add_option("-C --directory", "The workspace (default: the one around this folder).", type=PATH)
@click.argument("ignored", nargs=-1, type=click.UNPROCESSED, metavar="[CATKIN OPTION]...")
@json_option
def make(directory: Path | None, ignored: tuple[str, ...], as_json: bool) -> None:
    """Check the packages of a workspace and their messages, without a build.

    Messages, services and Python nodes work without a build. The command writes devel/setup.bash, which adds
    the workspace to ROS_PACKAGE_PATH. It lists C++ programs, which need a real ROS.
    """
    here = directory or Path.cwd()
    workspace = (workspace_of(here) or here).absolute()
    packages = read_workspace(workspace)
    written = write_setup_files(workspace)
    registry = Registry.from_environment([workspace / SOURCE_FOLDER])
    broken = broken_packages(workspace)
    for line in broken:
        warn(line)
    has_problems = bool(broken)
    for contents in packages:
        problems = definition_problems(contents, registry)
        has_problems = has_problems or bool(problems)
        _show(contents, problems, workspace, as_json=as_json)
    if not as_json:
        count = counted(len(packages), "package")
        write_line(f"{count} in {workspace / SOURCE_FOLDER}; nothing needs to be built")
        if any(file.name == "setup.bash" for file in written):
            write_line(f"In other shells, run `source {workspace / 'devel' / 'setup.bash'}`")
    for word in ignored:
        if word in _TARGETS:
            warn(f"{word}: {_TARGETS[word]}")
    if has_problems:
        raise click.exceptions.Exit(EXIT_FAILED)


def definition_problems(contents: PackageContents, registry: Registry) -> list[str]:
    """Return a line for every message, service or action of a package that cannot be used."""
    name = contents.description.name
    problems = []
    wanted: list[tuple[Callable[[str], object], str]] = [
        *((registry.message_type, each) for each in contents.messages),
        *((registry.message_type, f"{each}Action") for each in contents.actions),
        *((registry.service_type, each) for each in contents.services),
    ]
    for read, each in wanted:
        try:
            read(f"{name}/{each}")
        except RostetherError as error:
            problems.append(str(error))
    return problems


def _show(contents: PackageContents, problems: list[str], workspace: Path, *, as_json: bool) -> None:
    parts = {
        "messages": contents.messages,
        "services": contents.services,
        "actions": contents.actions,
        "nodes": contents.nodes,
        "launch files": contents.launch_files,
    }
    if as_json:
        record: dict[str, object] = {key.replace(" ", "_"): value for key, value in parts.items()}
        head = {"package": contents.description.name, "folder": str(contents.folder)}
        write_json({**head, **record, "problems": problems})
        return
    write_line(f"{contents.description.name} ({contents.folder.relative_to(workspace)})")
    for what, names in parts.items():
        if names:
            write_line(f"  {what}: {', '.join(names)}")
    if contents.compiled_sources:
        write_line(f"  need a real ROS to build: {', '.join(contents.compiled_sources)}")
    for line in (*problems, *filter(None, map(explain_python2, programs(contents.folder)))):
        warn(f"  {line}")


@verb(
    "make-libraries",
    """
    rostether role make-libraries ~/Arduino/libraries
    rostether role make-libraries . std_msgs mearm_model
    """,
)
@click.argument("directory", metavar="[DIR]", type=PATH, default=Path())
@click.argument("packages", nargs=-1, metavar="[PACKAGE]...")
@click.pass_context
def make_libraries(context: click.Context, directory: Path, packages: tuple[str, ...]) -> int:
    """Write ros_lib for Arduino to DIR (default: this folder), with the messages of all or of some packages.

    Messages of other packages that DIR already contains are kept, and generated again.
    """
    wanted = (*packages, *_generated_packages(directory)) if packages else ()
    code: int = context.invoke(
        firmware_lib, directory=directory, sketch=None, packages=wanted, msg_paths=(), as_json=False
    )
    return code


def _generated_packages(directory: Path) -> list[str]:
    """Return the packages in an existing library whose definitions are known."""
    from rostether.codegen.arduino_library import LIBRARY_NAME
    from rostether.codegen.library_source import SOURCE_FOLDER

    library = directory.expanduser() / LIBRARY_NAME
    registry = Registry.from_environment(())
    # The established make_libraries.py puts the packages' headers directly into the library.
    folders = [each for part in (f"{SOURCE_FOLDER}/*", "*") for each in library.glob(part) if each.is_dir()]
    names = sorted({each.name for each in folders})
    return [name for name in names if registry.messages(name) or registry.services(name)]


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
