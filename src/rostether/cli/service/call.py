"""`rostether service call`: one request, or one for each YAML document of a pipe."""

from __future__ import annotations

import click

from rostether.cli.access.completions import complete_services
from rostether.cli.access.graph_options import TOOL_ALLOW, GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option
from rostether.cli.access.ros2_habits import daemon_habits
from rostether.cli.service.services import CallOptions, services_of
from rostether.cli.shell.option_group import option_group
from rostether.cli.shell.output import json_option
from rostether.cli.shell.verbs import Verb

_call_options = option_group(
    "options",
    CallOptions,
    (
        click.option("-v", "--verbose", is_flag=True, help="Also print the request."),
        click.option("--wait", is_flag=True, help="Wait until a node offers the service."),
        click.option(
            "--timeout",
            "timeout_s",
            type=click.FloatRange(min=0, min_open=True),
            metavar="SECONDS",
            help="Give up after SECONDS (default: wait as long as the server runs).",
        ),
        click.option(
            "-r",
            "--rate",
            "rate_hz",
            type=click.FloatRange(min=0, min_open=True),
            metavar="HZ",
            help="With --ros2, call repeatedly at this rate.",
        ),
        json_option,
        msg_path_option,
    ),
)


@click.command(
    "call",
    cls=Verb,
    context_settings={"ignore_unknown_options": True},
    examples="""
    rostether service call /set_led "data: true"
    rostether service call /set_led true
    rostether service call --wait --timeout 5 /set_led "{data: false}"
    rostether service call --ros2 /set_led std_srvs/srv/SetBool "{data: true}"
    """,
)
@click.argument("service", shell_complete=complete_services)
@click.argument("arguments", nargs=-1, metavar="[ARGUMENTS]...")
@_call_options
@graph_options(allow=TOOL_ALLOW)
@daemon_habits
def call(service: str, arguments: tuple[str, ...], options: CallOptions, graph: GraphOptions) -> None:
    """Call a service and print its response.

    ARGUMENTS are YAML: one mapping of the request's fields, or the value of each field in order. Without
    them, requests come from a pipe, in YAML documents that are separated by ---. With --ros2 you can give the
    service's type first; missing fields have their defaults.
    """
    services_of(graph).call(service, arguments, options)
