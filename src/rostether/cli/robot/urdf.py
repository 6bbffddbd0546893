"""`rostether urdf` and `xacro`: check and show robot descriptions, and expand xacro files."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path

import click

from rostether.cli.shell.input import read_bytes
from rostether.cli.shell.option_group import EXISTING_FILE, PATH, add_flag, add_option, ignored_options
from rostether.cli.shell.output import json_option, warn, write_file, write_json, write_line
from rostether.cli.shell.verbs import verb, verb_group
from rostether.errors import ConfigError
from rostether.mechanisms.text import escape_line, write_failure
from rostether.packages.locate import package_folders
from rostether.pictures.tree import MAX_INDENTED, branch
from rostether.robot.robot_model import Joint, RobotModel
from rostether.robot.urdf import parse_urdf
from rostether.robot.xacro import expand_xacro, is_xacro, parse_mappings, xacro_dependencies

_file = click.argument("file", type=EXISTING_FILE)
_mappings = click.argument("mappings", nargs=-1, metavar="[ARGUMENT:=VALUE...]")


urdf = verb_group(
    "urdf",
    "Check and show robot descriptions, URDF or xacro.",
    {
        "check": ("urdf:check", "Check a description, like check_urdf."),
        "tree": ("urdf:tree", "Show links and joints."),
    },
    """
    rostether urdf check robot.urdf
    rostether urdf tree robot.urdf.xacro gripper:=true
    """,
    package="rostether.cli.robot",
)


@verb("check", "rostether urdf check robot.urdf\nrostether urdf check robot.urdf.xacro gripper:=true")
@_file
@_mappings
def check(file: Path, mappings: tuple[str, ...]) -> None:
    """Report errors in FILE, or show its tree of links; a .xacro file is expanded first."""
    model = _load(file, mappings)
    write_line(f"robot name is: {escape_line(model.name)}")
    write_line("---------- Successfully Parsed XML ---------------")
    write_line(f"root Link: {escape_line(model.root)} has {len(model.joints_below(model.root))} child(ren)")
    waiting = [(1, index, joint) for index, joint in _numbered_backward(model, model.root)]
    while waiting:
        depth, index, joint = waiting.pop()
        write_line(f"{'    ' * min(depth, MAX_INDENTED)}child({index}):  {escape_line(joint.child)}")
        waiting += [(depth + 1, below, each) for below, each in _numbered_backward(model, joint.child)]
    for problem in model.problems:
        warn(f"skipped: {escape_line(problem)}")
    for joint in model.joints.values():
        for doubt in _doubts(model, joint):
            warn(f"WARNING: joint {escape_line(joint.name)}: {escape_line(doubt)}")


@verb("tree", "rostether urdf tree robot.urdf")
@_file
@_mappings
@json_option
def tree(file: Path, mappings: tuple[str, ...], as_json: bool) -> None:
    """Show the links of FILE as a tree, with their joints: types, limits and mimicked joints."""
    model = _load(file, mappings)
    if as_json:
        for joint in model.joints.values():
            write_json(_record(joint))
        return
    write_line(escape_line(model.root))
    for line in _tree_lines(model):
        write_line(escape_line(line))


def _load(file: Path, mappings: tuple[str, ...]) -> RobotModel:
    data = read_bytes(file)
    if is_xacro(data):
        packages = package_folders(os.environ, Path.cwd())
        text = expand_xacro(file, parse_mappings(mappings), packages=packages)
        return parse_urdf(text, file=str(file))
    return parse_urdf(data, file=str(file))


def _doubts(model: RobotModel, joint: Joint) -> Iterator[str]:
    """Yield the probable mistakes in a joint, which check_urdf accepts."""
    limits = joint.limits
    if limits is not None and limits.lower > limits.upper:
        yield f"its lower limit {limits.lower:g} is above its upper limit {limits.upper:g}; exchange them"
    if joint.mimic is not None and joint.mimic.joint not in model.joints:
        yield f"it mimics {joint.mimic.joint!r}, which does not exist; correct the name"


def _numbered_backward(model: RobotModel, link: str) -> list[tuple[int, Joint]]:
    return list(enumerate(model.joints_below(link), start=1))[::-1]


def _tree_lines(model: RobotModel) -> Iterator[str]:
    waiting: list[tuple[str, str, Joint]] = []

    def push(link: str, indent: str) -> None:
        joints = model.joints_below(link)
        for index, joint in reversed(list(enumerate(joints))):
            waiting.append((*branch(indent, is_last=index == len(joints) - 1), joint))

    push(model.root, "")
    while waiting:
        lead, indent, joint = waiting.pop()
        yield f"{lead}{joint.child}  ({joint.name}: {_described(joint)})"
        push(joint.child, indent)


def _described(joint: Joint) -> str:
    words = [joint.type.value]
    limits = joint.limits
    if limits is not None and joint.type == "revolute":
        words.append(f"{math.degrees(limits.lower):.4g}° to {math.degrees(limits.upper):.4g}°")
    elif limits is not None and joint.type == "prismatic":
        words.append(f"{limits.lower:.4g} m to {limits.upper:.4g} m")
    if joint.mimic is not None:
        words.append(f"follows {joint.mimic.joint}")
    return ", ".join(words)


def _record(joint: Joint) -> dict[str, object]:
    limits = joint.limits
    return {
        "joint": joint.name,
        "type": joint.type.value,
        "parent": joint.parent,
        "child": joint.child,
        "translation_m": joint.origin.translation,
        "rotation_xyzw": joint.origin.rotation,
        "axis": joint.axis,
        "lower": limits.lower if limits is not None else None,
        "upper": limits.upper if limits is not None else None,
        "mimics": joint.mimic.joint if joint.mimic is not None else None,
    }


@verb(
    "xacro",
    """
    rostether xacro robot.urdf.xacro
    rostether xacro robot.urdf.xacro gripper:=true -o robot.urdf
    rostether xacro --deps robot.urdf.xacro
    """,
)
@_file
@_mappings
@add_option("-o --output FILE", "Write the URDF to this file.", type=PATH)
@add_flag("--deps", "Print the included files instead.")
@ignored_options(flags=["--inorder -i", "-q"])
def xacro(file: Path, mappings: tuple[str, ...], output: Path | None, deps: bool) -> None:
    """Expand FILE and print the URDF."""
    packages = package_folders(os.environ, Path.cwd())
    arguments = parse_mappings(mappings)
    if deps:
        write_line(" ".join(xacro_dependencies(file, arguments, packages=packages)))
        return
    text = expand_xacro(file, arguments, packages=packages)
    if output is None:
        write_line(text)
        return
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(write_failure(output.parent, error)) from None
    write_file(output, text)
