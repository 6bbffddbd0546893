"""`rostether node ping`: does a node answer, and how quickly."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import click

from rostether.cli.access.completions import complete_nodes
from rostether.cli.access.options import master_option
from rostether.cli.access.refusals import not_on_ros2
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.shell.failures import EXIT_FAILED, one_line
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.errors import GraphError, MasterUnreachableError, UnknownNameError

if TYPE_CHECKING:
    from rostether.ros1.node.master_client import MasterClient

INTERVAL_S = 1.0
"""Between pings, as rosnode has it."""


@click.command(
    "ping",
    cls=Verb,
    examples="""
    rostether node ping /board
    rostether node ping -c 3 /board
    rostether node ping --all
    """,
)
@click.argument("name", metavar="[NODE]", required=False, shell_complete=complete_nodes)
@click.option("-a", "--all", "ping_all", is_flag=True, help="Ping each node once.")
@click.option("-c", "count", type=click.IntRange(min=1), metavar="COUNT", help="Stop after COUNT pings.")
@json_option
@master_option
@ros1_option
@ros2_option
def ping(name: str | None, ping_all: bool, count: int | None, as_json: bool, master: str | None) -> None:
    """See whether a node answers, once a second until Ctrl-C; exit code 1 when one does not."""
    if chosen_ros2() is not None:
        raise not_on_ros2(
            "node ping", "a node of ROS 2 has no address; `rostether node info` shows whether it is there"
        )
    if ping_all and (name or count):
        raise click.UsageError("--all pings each node once: leave the node's name and -c out")
    if name is None and not ping_all:
        raise click.UsageError("which node? `rostether node list` shows those that run; --all pings them all")
    if not run(_ping_all(master, as_json) if name is None else _ping(name, count, master, as_json)):
        raise click.exceptions.Exit(EXIT_FAILED)


async def _ping(name: str, count: int | None, master: str | None, as_json: bool) -> bool:
    from rostether.cli.access.ros1_access import master_client, read_environment, resolve

    environment = read_environment(master)
    async with master_client(environment) as client:
        pinger = _Pinger(client, resolve(name, environment), as_json)
        if not as_json:
            write_line(f"rosnode: node is [{pinger.name}]")
        await pinger.find()
        try:
            while await pinger.ping():
                if len(pinger.replies_s) == count:
                    return True
                await asyncio.sleep(INTERVAL_S)
            return False
        finally:
            if len(pinger.replies_s) > 1 and not as_json:
                average_ms = sum(pinger.replies_s) / len(pinger.replies_s) * 1e3
                write_line(f"ping average: {average_ms:f}ms")


async def _ping_all(master: str | None, as_json: bool) -> bool:
    from rostether.cli.access.ros1_access import master_client, read_environment
    from rostether.cli.node.calls import node_names

    async with master_client(read_environment(master)) as client:
        names = await node_names(client)
        if not as_json:
            listed = "".join(f" * {name}\n" for name in names)
            write_line(f"Will ping the following nodes: \n{listed}")
        return all([await _ping_once(_Pinger(client, name, as_json)) for name in names])


async def _ping_once(pinger: _Pinger) -> bool:
    try:
        await pinger.find()
    except UnknownNameError:
        warn(f"cannot ping [{pinger.name}]: it has just left")
        return False
    return await pinger.ping()


class _Pinger:
    """Pings one node and prints how it went; `replies_s` are the round trips so far."""

    def __init__(self, master: MasterClient, name: str, as_json: bool) -> None:
        self.name = name
        self.replies_s: list[float] = []
        self._master = master
        self._as_json = as_json
        self._uri = ""

    async def find(self) -> None:
        """Look the node up. Raises UnknownNameError."""
        from rostether.cli.node.calls import NODE_TIMEOUT_S, find_node

        self._uri = await find_node(self._master, self.name)
        if not self._as_json:
            write_line(f"pinging {self.name} with a timeout of {NODE_TIMEOUT_S}s")

    async def ping(self) -> bool:
        """Ping once; a node that was started anew, at another address, is found again."""
        from rostether.cli.node import calls as node_calls

        try:
            reply_s = await node_calls.ping(self.name, self._uri)
        except MasterUnreachableError:
            raise
        except GraphError as error:
            if isinstance(error.__cause__, OSError) and await self._has_moved():
                return await self.ping()
            self._report_failure(error)
            return False
        self.replies_s.append(reply_s)
        if self._as_json:
            write_json({"node": self.name, "uri": self._uri, "reply_ms": reply_s * 1e3})
        else:
            write_line(f"xmlrpc reply from {self._uri}\ttime={reply_s * 1e3:f}ms")
        return True

    async def _has_moved(self) -> bool:
        from rostether.cli.node.calls import find_node

        uri = await find_node(self._master, self.name)
        if uri == self._uri:
            return False
        if not self._as_json:
            write_line(f"node url has changed from [{self._uri}] to [{uri}], retrying to ping")
        self._uri = uri
        return True

    def _report_failure(self, error: GraphError) -> None:
        if self._as_json:
            record = {"node": self.name, "uri": self._uri, "reply_ms": None, "error": one_line(error)}
            write_json(record)
        elif isinstance(error.__cause__, ConnectionRefusedError):
            warn(f"ERROR: connection refused to [{self._uri}]")
        elif error.__cause__ is None:
            warn(f"connection to [{self.name}] timed out")
        else:
            warn(f"ERROR: {one_line(error)}")
