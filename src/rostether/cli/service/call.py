"""`rostether service call`: one request, or one for each YAML document of a pipe."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.completions import complete_services
from rostether.cli.access.options import master_option, msg_path_option, tool_allow_option
from rostether.cli.access.refusals import refuse_ros1_only, refuse_ros2_only
from rostether.cli.access.ros2_daemon_options import daemon_habits
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.shell.output import json_option, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.errors import ServiceUnavailableError, UnknownNameError

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.ros1.node.master_client import MasterClient
    from rostether.serde.values import Message

WAIT_POLL_S = 0.2


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
@click.option("-v", "--verbose", is_flag=True, help="Print the request, too.")
@click.option("--wait", is_flag=True, help="Wait until somebody offers the service.")
@click.option(
    "--timeout",
    "timeout_s",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Give up after SECONDS; without it, wait as long as the server lives.",
)
@click.option(
    "-r",
    "--rate",
    "rate_hz",
    type=click.FloatRange(min=0, min_open=True),
    metavar="HZ",
    help="With --ros2, call again and again.",
)
@json_option
@msg_path_option
@master_option
@tool_allow_option
@ros1_option
@ros2_option
@daemon_habits
def call(
    service: str,
    arguments: tuple[str, ...],
    verbose: bool,
    wait: bool,
    timeout_s: float | None,
    rate_hz: float | None,
    as_json: bool,
    msg_paths: tuple[Path, ...],
    master: str | None,
) -> None:
    """Call a service and print its response.

    ARGUMENTS are YAML: one mapping of the request's fields, or the value of each field in order. Without
    them, requests come from a pipe, in YAML documents that are separated by ---. With --ros2 the service's
    type may stand before them, and what is not given has its default.
    """
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.service import ros2_call as ros2

        refuse_ros1_only(verbose=verbose, master=master)
        ros2.call(middleware, service, arguments, ros2.CallOptions(timeout_s, rate_hz, as_json), msg_paths)
        return
    refuse_ros2_only(rate_hz=rate_hz)
    run(_call(service, arguments, verbose, wait, timeout_s, as_json, msg_paths, master))


async def _call(
    service: str,
    arguments: tuple[str, ...],
    verbose: bool,
    wait: bool,
    timeout_s: float | None,
    as_json: bool,
    msg_paths: tuple[Path, ...],
    master: str | None,
) -> None:
    from rostether.cli.access.ros1_access import joined, master_client, read_environment, resolve
    from rostether.cli.service.probe import probe_type
    from rostether.serde.plain_form import to_plain
    from rostether.serde.yaml_print import format_message

    environment = read_environment(master)
    name = resolve(service, environment)
    async with master_client(environment) as client:
        if wait:
            await _wait_for_service(client, name, timeout_s)
        type_name = await probe_type(client, name)
    async with joined(environment, msg_paths, purpose="rosservice") as graph:
        async for request in _requests(graph, type_name, arguments):
            response = await graph.call(name, type_name, request, timeout_s=timeout_s)
            if as_json:
                write_json(to_plain(response))
                continue
            if verbose:
                write_line(f"{format_message(request)}\n---")
            write_line(format_message(response))


async def _requests(graph: TypedGraph, type_name: str, arguments: tuple[str, ...]) -> AsyncIterator[Message]:
    from rostether.cli.shell.piped_documents import piped_documents
    from rostether.serde.yaml_form import parse_documents, parse_values

    request_type = graph.store.registry.service_type(type_name).request.name
    codec = graph.store.codec(request_type)
    # An empty argument is the empty text, which YAML would take for nothing.
    texts = [argument or "''" for argument in arguments]
    if texts or not codec.message_class._fields:
        yield parse_values(codec, texts, now=graph.now)
        return
    is_any = False
    if not sys.stdin.isatty():
        async for text in piped_documents(sys.stdin):
            for request in parse_documents(codec, text, now=graph.now):
                is_any = True
                yield request
    if not is_any:
        fields = ", ".join(f"{name}: {field_type}" for name, field_type in codec.message_class._fields)
        raise click.UsageError(f"give the request as YAML: {type_name} takes {{{fields}}}")


async def _wait_for_service(client: MasterClient, name: str, timeout_s: float | None) -> None:
    try:
        async with asyncio.timeout(timeout_s):
            while True:
                try:
                    await client.lookup_service(name)
                except UnknownNameError:
                    await asyncio.sleep(WAIT_POLL_S)
                else:
                    return
    except TimeoutError:
        raise ServiceUnavailableError(f"nobody offered the service {name} within {timeout_s:g} s") from None
