"""`rostether node`: the table of its verbs."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_VERBS_MODULE = "rostether.cli.node.verbs:"
_VERBS = {
    "list": VerbEntry(f"{_VERBS_MODULE}list_nodes", "List the running nodes."),
    "info": VerbEntry(f"{_VERBS_MODULE}info", "Show what a node publishes, subscribes to and serves."),
    "ping": VerbEntry(f"{_VERBS_MODULE}ping", "Check whether a node answers, and how quickly."),
    "kill": VerbEntry(f"{_VERBS_MODULE}kill", "Ask nodes to shut down."),
    "cleanup": VerbEntry(f"{_VERBS_MODULE}cleanup", "Unregister dead nodes from the master."),
    "machine": VerbEntry(f"{_VERBS_MODULE}machine", "List machines, or the nodes on one."),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether node list
    rostether node info /board
    rostether node ping -a
    """,
)
def node() -> None:
    """List, show, ping and stop the nodes of a ROS graph."""
