"""Reads a definition from a file."""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

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
