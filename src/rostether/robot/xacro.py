"""Expands xacro files with the package xacro (extra `robot`), and finds packages for $(find).

xacro evaluates expressions with Python, so it is used only for files that the user names.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rostether.errors import ConfigError, RobotModelError
from rostether.extras import install_command
from rostether.mechanisms.text import fold_line
from rostether.robot.urdf import parse_robot_xml
from rostether.robot.xacro_bounds import bounded

ASSIGNMENT = ":="

_XACRO = re.compile(rb"<xacro:|xmlns:xacro")


def is_xacro(data: bytes) -> bool:
    """Return whether a robot description is a xacro file, which must be expanded."""
    return _XACRO.search(data) is not None


def parse_mappings(words: Iterable[str]) -> dict[str, str]:
    """Return the values of `name:=value` arguments. Raises ConfigError for other arguments."""
    mappings = {}
    for word in words:
        name, assignment, value = word.partition(ASSIGNMENT)
        if not assignment or not name:
            raise ConfigError(f"{word!r} is not an argument of the xacro file; write name:=value")
        mappings[name] = value
    return mappings


def expand_xacro(file: Path, mappings: Mapping[str, str], *, packages: Mapping[str, Path]) -> str:
    """Return the URDF that a xacro file expands to.

    `packages` are the folders for $(find). Raises RobotModelError, also if the package xacro is not
    installed.
    """
    xacro = _xacro(file)
    try:
        # xacro would expand a DTD without limits.
        parse_robot_xml(file.read_bytes(), file=str(file))
    except OSError as error:
        raise RobotModelError(f"{file}: {error.strerror}") from error
    with _finding(xacro, packages), bounded(xacro, file):
        try:
            document = xacro.process_file(str(file), mappings=dict(mappings))
        except RobotModelError:
            raise
        except RecursionError as error:
            raise RobotModelError(f"{file}: its macros or files call each other endlessly") from error
        # Expressions in the file may raise any exception.
        except Exception as error:
            raise RobotModelError(_explain(file, xacro, error)) from error
    text: str = document.toprettyxml(indent="  ")
    return text


def xacro_dependencies(file: Path, mappings: Mapping[str, str], *, packages: Mapping[str, Path]) -> list[str]:
    """Return the files that a xacro file includes, sorted. Raises RobotModelError."""
    xacro = _xacro(file)
    xacro.all_includes.clear()
    expand_xacro(file, mappings, packages=packages)
    return sorted(set(xacro.all_includes))


def _xacro(file: Path) -> Any:
    try:
        import xacro
        import xacro.substitution_args
    except ImportError:
        raise RobotModelError(
            f"{file} is xacro, which needs the package xacro; run: {install_command('robot')}"
        ) from None
    return xacro


@contextmanager
def _finding(xacro: Any, packages: Mapping[str, Path]) -> Iterator[None]:
    # xacro uses the ament index of ROS 2, which is not installed.
    arguments = xacro.substitution_args
    before = arguments._eval_find

    def find(name: str) -> str:
        folder = packages.get(name)
        if folder is None:
            raise RobotModelError(
                f"$(find {name}): no package {name} on ROS_PACKAGE_PATH, in the workspace around this folder "
                "or below it; `rostether pkg list` shows those found"
            )
        return str(folder)

    arguments._eval_find = arguments._eval_dict["find"] = find
    try:
        yield
    finally:
        arguments._eval_find = arguments._eval_dict["find"] = before


def _explain(file: Path, xacro: Any, error: Exception) -> str:
    cause: BaseException = error
    while isinstance(inner := getattr(cause, "exc", None) or cause.__cause__, Exception):
        cause = inner
    place = next((str(each) for each in reversed(xacro.filestack or ()) if each), str(file))
    text = fold_line(str(error)) or type(cause).__name__
    return text if isinstance(cause, RobotModelError) else f"{place}: {text}"
