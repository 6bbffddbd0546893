"""`rostether run`: one node of a package, like rosrun, and the command lines of nodes."""

from __future__ import annotations

import functools
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

import click

from rostether.cli.dashboard.view import has_browser
from rostether.cli.launch.builtin_nodes import BUILTIN_NODES, replacement_line, view_command, window_program
from rostether.cli.launch.pkg import complete_package_folders, complete_programs, packages_here
from rostether.cli.shell.option_group import add_flag, add_option
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.own_command import own_command, replace_process
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.text import did_you_mean
from rostether.packages.executables import find_program, is_python, library_folders, shebang
from rostether.packages.python_scripts import explain_python2, imported_modules
from rostether.rospy.environment import script_environment

PYTHON_VARIABLE = "ROSTETHER_PYTHON"

# A Python starts within a second, even on a busy small board.
_PROBE_LIMIT_S = 10.0
# A Python with a real rospy must also find the built packages of the workspace that the script imports.
# A Python without it must be new enough for the built-in rospy. A folder without `__init__.py` has no origin.
_PROBE = """
import importlib.util, sys
del sys.path[0]
def has(name):
    spec = importlib.util.find_spec(name)
    return spec is not None and spec.origin is not None
print(all(map(has, sys.argv[1:])) if has("rospy") else sys.version_info >= (3, 11))
"""


@verb(
    "run",
    """
    rostether run mearm_model filter.py
    rostether run mearm_model move.py __name:=mover joint_states:=/arm/joint_states
    rostether run rosserial_python serial_node.py _port:=/dev/ttyACM0 _baud:=115200
    rostether run topic_tools relay /chatter /copy
    rostether run --prefix "nice -n 10" mearm_model filter.py
    """,
    context_settings={"ignore_unknown_options": True, "allow_interspersed_args": False},
)
@add_option("-p --prefix COMMAND", "Run the node through this command.", default="")
@add_flag("-d --debug", "Print the command line that is run.")
@click.argument("package", shell_complete=complete_package_folders)
@click.argument("program", metavar="NODE", shell_complete=complete_programs)
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="[ARGUMENT | NAME:=VALUE]...")
def run(prefix: str, debug: bool, package: str, program: str, arguments: tuple[str, ...]) -> None:
    """Run a node of a package, without a build and without a ROS installation.

    Packages are found on ROS_PACKAGE_PATH, in the catkin workspace around this folder, and below it. Nodes
    such as serial_node.py, relay and robot_state_publisher are built in. All arguments after the node's name
    go to the node.
    """
    in_terminal = not has_browser(os.environ)
    if line := replacement_line(package, os.environ, in_terminal=in_terminal):
        warn(line)
        replace_process(view_command(package, arguments, in_terminal=in_terminal), os.environ)
    # Searching a home directory takes time, and built-in nodes are not in a folder.
    is_built_in = (package, program) in BUILTIN_NODES
    packages = {} if is_built_in else packages_here()
    found = node_command(package, program, packages=packages, environ=os.environ)
    words = [*shlex.split(prefix), *found, *arguments]
    if debug:
        write_line(shlex.join(words))
    replace_process(words, script_environment(os.environ, packages))


def node_command(
    package: str, program: str, *, packages: Mapping[str, Path], environ: Mapping[str, str]
) -> list[str]:
    """Return the command line of `rosrun PACKAGE PROGRAM`; `packages` are the folders of all packages.

    Start it in the environment that `rospy.environment.script_environment` returns.
    Raises ConfigError with similar names if there is no such package or program.
    """
    if words := BUILTIN_NODES.get((package, program)):
        return own_command(*words)
    folder = packages.get(package)
    if folder is None:
        window = window_program(package, program, environ)
        if window is not None and package == program:
            return [str(window)]
        if not any((each / program).is_file() for each in library_folders(package, None, environ)):
            raise ConfigError(_explain_unknown_package(package, program, packages))
    found = find_program(package, program, folder, environ)
    if not is_python(found):
        return [str(found)]
    python = python_for(found, environ, packages)
    if not Path(python[0]).name.startswith("python2") and (reason := explain_python2(found)):
        raise ConfigError(reason)
    return [*python, str(found)]


def _explain_unknown_package(package: str, program: str, packages: Mapping[str, Path]) -> str:
    """Return the error about a package without a folder: its built-in programs, or similar names."""
    built_in = sorted(each for owner, each in BUILTIN_NODES if owner == package)
    if built_in:
        return f"package {package} has no program {program}; the built-in ones are {', '.join(built_in)}"
    known = {*packages, *(owner for owner, _ in BUILTIN_NODES)}
    if hint := did_you_mean(package, known):
        return f"no package {package}; {hint}"
    return (
        f"no package {package} on ROS_PACKAGE_PATH, in the workspace around this folder or below it; "
        "`rostether pkg list` shows those found"
    )


def python_for(script: Path, environ: Mapping[str, str], packages: Iterable[str] = ()) -> list[str]:
    """Return the words before the script's path on its command line: a Python, and flags of its first line.

    With these words, scripts also run if they are not executable or have Windows line ends.
    """
    if chosen := environ.get(PYTHON_VARIABLE):
        return [chosen]
    words = shebang(script).split()
    if words and Path(words[0]).name == "env":
        words = [each for each in words[1:] if each != "-S" and "=" not in each]
    named = shutil.which(words[0], path=environ.get("PATH")) if words else None
    needed = tuple(sorted(imported_modules(script).intersection(packages)))
    if named is None or not _is_usable(named, environ.get("PYTHONPATH", ""), needed):
        return [sys.executable]
    return [named, *words[1:]]


@functools.cache
def _is_usable(python: str, python_path: str, needed: tuple[str, ...]) -> bool:
    """Return whether a Python has a real rospy and the needed packages, or can use the built-in rospy."""
    if python == sys.executable:
        return True
    try:
        answer = subprocess.run(  # noqa: S603 - the program that the user's script names
            [python, "-c", _PROBE, *needed],
            env={**os.environ, "PYTHONPATH": python_path},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_PROBE_LIMIT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return answer.stdout.strip() == b"True"
