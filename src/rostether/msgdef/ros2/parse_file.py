"""Reads a definition from a file, and recognizes those of ROS 2."""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

from rostether.errors import DefinitionError
from rostether.msgdef.definition_files import Kind, read_definition
from rostether.msgdef.ros2.parse import parse_action, parse_message, parse_service
from rostether.msgdef.ros2.spec import Ros2Action, Ros2Message, Ros2Service

Definition: TypeAlias = Ros2Message | Ros2Service | Ros2Action


def parse_file(kind: Kind, file: Path, package: str, name: str) -> Definition:
    """Return the definition in a file. Raises DefinitionError."""
    text = read_definition(file)
    if kind is Kind.ACTION:
        return parse_action(text, package=package, name=name, file=str(file))
    if kind is Kind.SERVICE:
        return parse_service(text, package=package, name=name, file=str(file))
    return parse_message(text, package=package, name=name, file=str(file))


def reads_as_ros2(kind: Kind, file: Path, package: str, *, has_header: bool) -> bool:
    """Return whether a text is valid in ROS 2; `has_header`: its package defines a `Header`."""
    try:
        found = parse_file(kind, file, package, file.stem)
    except DefinitionError:
        return False
    if has_header or package == "std_msgs":
        return True
    # A plain `Header` is std_msgs' in ROS 1 and the package's own in ROS 2.
    header = f"{package}/msg/Header"
    return not any(field.type.base == header for part in found.parts for field in part.fields)
