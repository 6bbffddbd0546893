"""The queries of tools about nodes, to the master and to the nodes."""

from __future__ import annotations

import re
import time
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from typing import Any

from msgspec import Struct

from rostether.errors import ConfigError, GraphError, UnknownNameError
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.text import did_you_mean
from rostether.msgdef.interface import ANY_TYPE
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.xmlrpc_client import XmlRpcClient

# The caller id of tools that start no node, and the meaning of `~` in their names.
TOOL_NAME = "/rostether"

# The same as in rosnode: a node answers within milliseconds, over a bad radio link within a second or two.
NODE_TIMEOUT_S = 3.0

_CONNECTION = re.compile(r"\w+ connection on port (\d+) to \[(.*) on socket (\d+)\]")


class NodeRegistrations(Struct, frozen=True):
    """The registrations of one node; topics have their types."""

    publications: dict[str, str]
    subscriptions: dict[str, str]
    services: list[str]


class NodeConnection(Struct, frozen=True):
    """One connection of a node. `peer` is a node's name, `peer_uri` its address if the node reports that.

    `sockets` is (local port, remote address, descriptor), or None if the node does not report it.
    """

    topic: str
    peer: str
    peer_uri: str
    direction: str
    transport: str
    sockets: tuple[str, str, str] | None


async def node_names(master: MasterClient) -> list[str]:
    """Return the names of all nodes that have registered something, sorted. Raises the errors of `master`."""
    return sorted(
        {name for table in await master.system_state() for names in table.values() for name in names}
    )


async def registrations(master: MasterClient, name: str) -> NodeRegistrations:
    """Return the registrations of a node. Raises the errors of `master`."""
    publishers, subscribers, services = await master.system_state()
    types = await master.topic_types()

    def topics(table: dict[str, list[str]]) -> dict[str, str]:
        return {topic: types.get(topic, ANY_TYPE) for topic in sorted(table) if name in table[topic]}

    return NodeRegistrations(
        topics(publishers),
        topics(subscribers),
        sorted(service for service, providers in services.items() if name in providers),
    )


async def find_node(master: MasterClient, name: str) -> str:
    """Return a node's URI. Raises UnknownNameError with the most similar name."""
    try:
        return await master.lookup_node(name)
    except UnknownNameError:
        raise unknown_node(name, await node_names(master)) from None


def unknown_node(name: str, known: Iterable[str]) -> UnknownNameError:
    """Return the error for an unknown node."""
    hint = did_you_mean(name, known) or "`rostether node list` shows the running nodes"
    return UnknownNameError(f"no node is called {name}; {hint}")


@asynccontextmanager
async def node_client(name: str, uri: str) -> AsyncIterator[XmlRpcClient]:
    """Open a client for calls to a node. Raises GraphError if its URI is not valid."""
    try:
        client = XmlRpcClient(uri, peer=f"node {name}", timeout_s=NODE_TIMEOUT_S)
    except ConfigError as error:
        raise GraphError(f"node {name} has registered an invalid address: {error}") from None
    async with closed_at_end(client):
        yield client


async def ask(client: XmlRpcClient, method: str, *arguments: object) -> Any:
    """Return a node's answer to one call. Raises GraphError."""
    code, text, value = await client.call_status(method, TOOL_NAME, *arguments)
    if code != 1:
        raise GraphError(f"{client.peer} refused {method}: {text}")
    return value


async def ping(name: str, uri: str, clock: Callable[[], float] = time.perf_counter) -> float:
    """Return a node's response time in seconds. Raises GraphError; its cause is the OSError, if any."""
    async with node_client(name, uri) as client:
        start_s = clock()
        await ask(client, "getPid")
        return clock() - start_s


async def connections(master: MasterClient, client: XmlRpcClient) -> list[NodeConnection]:
    """Return the connections that a node reports, with the names of its peers. Raises GraphError."""
    publishers, subscribers, _ = await master.system_state()
    names: dict[str, str] = {}
    found = []
    for entry in await ask(client, "getBusInfo"):
        if not isinstance(entry, list) or len(entry) < 5 or (len(entry) > 5 and not entry[5]):
            continue
        topic, peer = str(entry[4]), str(entry[1])
        name = peer
        if "://" in peer:
            members = {*publishers.get(topic, ()), *subscribers.get(topic, ())}
            name = await _name_of(master, peer, members, names)
        match = _CONNECTION.match(str(entry[6])) if len(entry) > 6 else None
        sockets = (match[1], match[2], match[3]) if match else None
        direction = {"i": "inbound", "o": "outbound"}.get(str(entry[2]), "unknown")
        found.append(
            NodeConnection(topic, name, peer if name != peer else "", direction, str(entry[3]), sockets)
        )
    return found


async def _name_of(master: MasterClient, uri: str, members: Iterable[str], names: dict[str, str]) -> str:
    """Return the node with the URI, or the URI; `names` caches the results by URI."""
    for name in members:
        if uri in names:
            break
        if name not in names.values():
            try:
                names[await master.lookup_node(name)] = name
            except UnknownNameError:
                continue
    return names.get(uri, uri)
