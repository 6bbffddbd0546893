"""The plan of launch files, with the packages that this command finds and the environment of the nodes."""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

from msgspec import Struct

from rostether.cli.access.graph_options import ros_arguments
from rostether.cli.dashboard.view import View, read_view
from rostether.cli.launch.builtin_nodes import BUILTIN_NODES, replacement_line, window_view
from rostether.cli.launch.pkg import packages_here
from rostether.cli.launch.run import node_command
from rostether.cli.shell.input import STDIN, read_bytes
from rostether.cli.shell.output import warn
from rostether.cli.shell.own_command import own_command
from rostether.errors import ConfigError
from rostether.launch.command_line import Locate, Program, Replaced
from rostether.launch.loading import load_launch
from rostether.launch.plan import LaunchPlan
from rostether.launch.sources import LaunchSources, bundled_launch_packages, find_sources
from rostether.launch.substitution import LaunchContext
from rostether.packages.locate import package_around, package_folders
from rostether.rospy.environment import script_environment

_PACKAGE_PATH = "ROS_PACKAGE_PATH"

# Linux cannot start a process with a variable of 128 KB.
_MAX_PATH_CHARS = 100_000


class LoadedLaunch(Struct, frozen=True):
    """A plan, its files, the environment of its nodes, and `locate`, which finds their programs."""

    plan: LaunchPlan
    sources: LaunchSources
    environ: Mapping[str, str]
    locate: Locate

    @property
    def views(self) -> list[View]:
        """The dashboard panels that replace windows of rviz and rqt, if these are not installed."""
        views: dict[str, View] = {}
        for node in self.plan.nodes:
            if replacement_line(node.package, os.environ) is None:
                continue
            panel, shown = window_view(node.package, _words(node.args))
            try:
                views[panel] = read_view(panel, shown)
            except ConfigError as error:
                warn(f"WARNING: {node.name}: {error}")
                views[panel] = View(panel)
        return list(views.values())

    @property
    def package_folders(self) -> list[Path]:
        """Folders of the packages that the nodes see; the dashboard shows their meshes and messages."""
        return [Path(part) for part in self.environ.get(_PACKAGE_PATH, "").split(os.pathsep) if part]

    def warn(self) -> None:
        """Print the warnings of the files, and those about arguments."""
        for line in self.plan.warnings:
            warn(f"WARNING: {line}")
        for name in self.sources.arguments.keys() - self.plan.argument_names:
            warn(f"WARNING: the launch file declares no argument {name}; --ros-args shows the declared ones")
        for name in self.sources.empty_arguments:
            warn(f"WARNING: {name}:= has no value and is ignored, as with roslaunch")


def load(words: Sequence[str], *, runs_commands: bool) -> LoadedLaunch:
    """Load the launch files that the words name. Raises ConfigError, LaunchError.

    Without `runs_commands`, `<param command="...">` runs no program.
    """
    packages = packages_here()
    packages |= {name: folder for name, folder in bundled_launch_packages().items() if name not in packages}
    sources = find_sources(words, packages)
    for file in sources.files:
        # A file given by its path also sees its own package and the packages beside it.
        if (package := package_around(file.absolute().parent)) is not None:
            packages = package_folders({}, package) | packages
    near = _nearest(packages)
    environ = _environ_for(near)
    context = LaunchContext(
        environ,
        packages,
        builtin_packages={package for package, _ in BUILTIN_NODES},
        # Launch files run it for a parameter's value: `$(find xacro)/xacro`.
        programs={("xacro", "xacro"): own_command("xacro")},
        runs_commands=runs_commands,
    )
    text = read_bytes(STDIN) if sources.reads_stdin else None
    plan = load_launch(sources.files, {**sources.arguments, **ros_arguments()}, context, text=text)
    return LoadedLaunch(plan, sources, environ, _locator(packages, near))


def _words(args: str) -> list[str]:
    try:
        return shlex.split(args)
    except ValueError:
        # An unclosed quote; the node would not start either.
        return args.split()


def _locator(packages: Mapping[str, Path], near: Mapping[str, Path]) -> Locate:
    def locate(package: str, node_type: str, environ: Mapping[str, str]) -> Program | Replaced:
        if line := replacement_line(package, environ):
            return Replaced(line)
        words = node_command(package, node_type, packages=packages, environ=environ)
        return Program(words, script_environment(environ, near))

    return locate


def _environ_for(packages: Mapping[str, Path]) -> dict[str, str]:
    """Return this process's environment, with all packages found here: nodes start in another folder."""
    given = [part for part in os.environ.get(_PACKAGE_PATH, "").split(os.pathsep) if part]
    roots = [Path(part).absolute() for part in given]
    others = [each for each in packages.values() if not any(each.is_relative_to(root) for root in roots)]
    path = os.pathsep.join(map(str, (*roots, *others)))
    return {**os.environ, _PACKAGE_PATH: path} if path else dict(os.environ)


def _nearest(packages: Mapping[str, Path]) -> dict[str, Path]:
    """Return as many packages, the nearest first, as fit into a variable of the nodes' environment."""
    found: dict[str, Path] = {}
    length = 0
    for name, folder in packages.items():
        length += len(str(folder)) + 1
        if length > _MAX_PATH_CHARS:
            break
        found[name] = folder
    return found
