"""`rostether param`: the table of its verbs."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_VERBS_MODULE = "rostether.cli.param.verbs:"
_VERBS = {
    "list": VerbEntry(f"{_VERBS_MODULE}list_params", "List the names of parameters."),
    "get": VerbEntry(f"{_VERBS_MODULE}get", "Print a parameter, or all of a namespace."),
    "set": VerbEntry(f"{_VERBS_MODULE}set_param", "Set a parameter."),
    "delete": VerbEntry(f"{_VERBS_MODULE}delete", "Delete a parameter, or all of a namespace."),
    "describe": VerbEntry(f"{_VERBS_MODULE}describe", "Describe the parameters of a ROS 2 node."),
    "dump": VerbEntry(f"{_VERBS_MODULE}dump_params", "Write parameters to a YAML file."),
    "load": VerbEntry(f"{_VERBS_MODULE}load", "Set the parameters of a YAML file."),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether param set /blink_hz 2.5
    rostether param get /blink_hz
    rostether param dump settings.yaml
    rostether param get --ros2 /board gain
    """,
)
def param() -> None:
    """Read and write the parameters of a ROS graph."""
