"""`node ping`: whether a node answers, and how quickly."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rostether.cli.access.ros1_access import master_client, resolve
from rostether.cli.shell.failures import error_text
from rostether.cli.shell.output import warn, write_json, write_line, write_result
from rostether.errors import GraphError, MasterUnreachableError, UnknownNameError
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node import node_queries
from rostether.ros1.node.node_queries import NODE_TIMEOUT_S, find_node, node_names

if TYPE_CHECKING:
    from rostether.ros1.node.master_client import MasterClient

# The pause between pings, like rosnode's.
INTERVAL_S = 1.0


async def ping(environment: RosEnvironment, name: str, count: int | None, *, as_json: bool) -> bool:
    """Ping a node once a second, `count` times or until it fails; return whether it always answered.

    Raises InvalidNameError, UnknownNameError, MasterUnreachableError.
    """
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


async def ping_all(environment: RosEnvironment, *, as_json: bool) -> bool:
    """Ping each node once; return whether all answered. Raises MasterUnreachableError."""
    async with master_client(environment) as client:
        names = await node_names(client)
        if not as_json:
            listed = "".join(f" * {name}\n" for name in names)
            write_line(f"Will ping the following nodes: \n{listed}")
        return all([await _ping_once(_Pinger(client, name, as_json)) for name in names])


async def _ping_once(pinger: _Pinger) -> bool:
    try:
        await pinger.find()
    except UnknownNameError:
        warn(f"cannot ping [{pinger.name}]: it has just unregistered")
        return False
    return await pinger.ping()


class _Pinger:
    """Pings one node and prints the results; `replies_s` are the round trips so far."""

    def __init__(self, master: MasterClient, name: str, as_json: bool) -> None:
        self.name = name
        self.replies_s: list[float] = []
        self._master = master
        self._as_json = as_json
        self._uri = ""

    async def find(self) -> None:
        """Look the node up. Raises UnknownNameError."""
        self._uri = await find_node(self._master, self.name)
        if not self._as_json:
            write_line(f"pinging {self.name} with a timeout of {NODE_TIMEOUT_S}s")

    async def ping(self) -> bool:
        """Ping once; a node that was restarted at another address is found again."""
        try:
            reply_s = await node_queries.ping(self.name, self._uri)
        except MasterUnreachableError:
            raise
        except GraphError as error:
            if isinstance(error.__cause__, OSError) and await self._has_moved():
                return await self.ping()
            self._report_failure(error)
            return False
        self.replies_s.append(reply_s)
        write_result(
            {"node": self.name, "uri": self._uri, "reply_ms": reply_s * 1e3},
            f"xmlrpc reply from {self._uri}\ttime={reply_s * 1e3:f}ms",
            as_json=self._as_json,
        )
        return True

    async def _has_moved(self) -> bool:
        uri = await find_node(self._master, self.name)
        if uri == self._uri:
            return False
        if not self._as_json:
            write_line(f"node url has changed from [{self._uri}] to [{uri}], retrying to ping")
        self._uri = uri
        return True

    def _report_failure(self, error: GraphError) -> None:
        if self._as_json:
            record = {"node": self.name, "uri": self._uri, "reply_ms": None, "error": error_text(error)}
            write_json(record)
        elif isinstance(error.__cause__, ConnectionRefusedError):
            warn(f"ERROR: connection refused to [{self._uri}]")
        elif error.__cause__ is None:
            warn(f"connection to [{self.name}] timed out")
        else:
            warn(f"ERROR: {error_text(error)}")
