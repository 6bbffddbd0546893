"""Expanding xacro files, by the package xacro (extra `robot`), with $(find) answered from package folders.

xacro evaluates expressions of the file with Python, so it is used on files that the user names only.
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
    """Return whether a robot description is xacro, to be expanded before it is read."""
    return _XACRO.search(data) is not None


def parse_mappings(words: Iterable[str]) -> dict[str, str]:
    """Return what `name:=value` arguments set. Raises ConfigError for other words."""
    mappings = {}
    for word in words:
        name, assignment, value = word.partition(ASSIGNMENT)
        if not assignment or not name:
            raise ConfigError(f"{word!r} is not an argument of the xacro file; write name:=value")
        mappings[name] = value
    return mappings


def expand_xacro(file: Path, mappings: Mapping[str, str], *, packages: Mapping[str, Path]) -> str:
    """Return the URDF that a xacro file expands to.

    `packages` are the folders that $(find) answers with. Raises RobotModelError, also when the package xacro
    is not installed.
    """
    xacro = _xacro(file)
    try:
        # Its DTD, if it had one, would be expanded without bounds.
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
        # Expressions of the file may raise anything.
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
    # xacro asks ROS 2's ament index, which is not there.
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
