"""`rostether service`: the table of its verbs."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_VERBS_MODULE = "rostether.cli.service.verbs:"
_VERBS = {
    "list": VerbEntry(f"{_VERBS_MODULE}list_services", "List the services."),
    "info": VerbEntry(
        f"{_VERBS_MODULE}info", "Show which node offers a service, its type and its arguments."
    ),
    "call": VerbEntry("rostether.cli.service.call:call", "Call a service and print its response."),
    "type": VerbEntry(f"{_VERBS_MODULE}type_of", "Print the type of a service."),
    "args": VerbEntry(f"{_VERBS_MODULE}args", "Print the names of a service's arguments."),
    "find": VerbEntry(f"{_VERBS_MODULE}find", "List the services of a type."),
    "node": VerbEntry(f"{_VERBS_MODULE}node_of", "Print the node that offers a service."),
    "uri": VerbEntry(f"{_VERBS_MODULE}uri_of", "Print the URI of a service."),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether service list
    rostether service call /set_led "data: true"
    rostether service type /set_led | rostether srv show
    """,
)
def service() -> None:
    """List, show and call the services of a ROS graph."""
