"""From (package, program) to the process to start: our own node, the user's script, the user's binary.

Python nodes run under this very Python with our `rospy` on their path, unless a real rospy is there already
(its environment was sourced): then they run as they stand, under the interpreter that they name.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

from rostether.cli.served_nodes import served_nodes, window_program
from rostether.errors import ConfigError
from rostether.packages.executables import find_program, is_python, library_folders

FACADE_FOLDER = Path(__file__).parent.parent / "rospy_facade" / "path"
"""What stands on the path of the users' Python nodes where there is no real ROS."""

_PYTHON_PATH = "PYTHONPATH"


@dataclass(frozen=True, slots=True)
class NodeCommand:
    """A process to start: its command line, and what its environment has on top of the caller's."""

    words: list[str]
    environ: dict[str, str] = field(default_factory=dict)


def node_command(
    package: str, program: str, *, packages: Mapping[str, Path], environ: Mapping[str, str]
) -> NodeCommand:
    """Find what `rosrun PACKAGE PROGRAM` means; `packages` are the folders of all packages that are seen.

    Raises ConfigError: no such package or program, with those that are near.
    """
    if served := served_nodes().get((package, program)):
        return NodeCommand(served)
    folder = packages.get(package)
    if folder is None:
        window = window_program(package, program, environ)
        if window is not None and package == program:
            return NodeCommand([str(window)])
        if not any((each / program).is_file() for each in library_folders(package, None, environ)):
            raise ConfigError(explain_unknown_package(package, program, packages))
    found = find_program(package, program, folder, environ)
    if is_python(found) and not has_real_rospy():
        return NodeCommand([sys.executable, str(found)], facade_environ(environ))
    return NodeCommand([str(found)])


def facade_environ(environ: Mapping[str, str]) -> dict[str, str]:
    """Return the variables that let a Python node find our `rospy` and message modules."""
    paths = [str(FACADE_FOLDER), *filter(None, [environ.get(_PYTHON_PATH)])]
    return {_PYTHON_PATH: os.pathsep.join(paths)}


def has_real_rospy() -> bool:
    """Tell whether this Python finds a rospy that is not ours."""
    spec = importlib.util.find_spec("rospy")
    return spec is not None and spec.origin is not None and FACADE_FOLDER not in Path(spec.origin).parents


def explain_unknown_package(package: str, program: str, packages: Mapping[str, Path]) -> str:
    """Return the line about a package that nobody has: what is near, or where packages are looked for."""
    ours = sorted(kind for role, kind in served_nodes() if role == package)
    if ours:
        return f"package {package} has no program {program}; of it we serve {', '.join(ours)}"
    there = {*packages, *(role for role, _ in served_nodes())}
    near = get_close_matches(package, there)
    if near:
        return f"no package {package}; did you mean {' or '.join(near)}?"
    return (
        f"no package {package} on ROS_PACKAGE_PATH, in the workspace around this folder or below it; "
        "`rostether pkg list` shows those found"
    )
