"""The functions of rosnode for programs: they list nodes, ping them, and end them."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from contextlib import suppress

from rostether.errors import ConfigError, RostetherError
from rostether.ros1.environment import parse_rpc_uri
from rostether.ros1.machines import hosts_of_machine
from rostether.ros1.node.node_queries import NODE_TIMEOUT_S, ask, node_client, ping
from rostether.rospy.client.node import node
from rostether.rospy.tools.graph_names import make_global_ns
from rostether.rospy.tools.master_tools import Master, MasterError, MasterException, master_required

# As in rosnode.
PING_INTERVAL_S = 1.0
_OWN_NAME = "/rosnode"


class ROSNodeException(Exception):
    """The base of rosnode's errors."""


class ROSNodeIOException(ROSNodeException):
    """The master does not answer."""


def get_node_names(namespace: str | None = None) -> list[str]:
    """Return the names of all nodes, or of those in a namespace, unsorted. Raises ROSNodeIOException."""
    found = {name for table in _state() for _, nodes in table for name in nodes}
    if namespace:
        below = make_global_ns(namespace)
        found = {name for name in found if name == namespace or name.startswith(below)}
    return list(found)


def get_api_uri(master: Master, caller_id: str, skip_cache: bool = False) -> str | None:
    """Return the URI of a node; None if the master does not know it. Raises ROSNodeIOException."""
    with master_required(ROSNodeIOException):
        try:
            return str(master.lookupNode(caller_id))
        except MasterError:
            return None


def get_machines_by_nodes() -> list[str]:
    """Return the machines that nodes run on. Raises ROSNodeIOException."""
    return list(dict.fromkeys(machine for _, machine in _machines()))


def get_nodes_by_machine(machine: str) -> list[str]:
    """Return the nodes on a machine, which is a host name or an address. Raises ROSNodeIOException."""
    nodes = list(_machines())
    hosts = hosts_of_machine(machine, (host for _, host in nodes))
    return [name for name, host in nodes if host in hosts]


def rosnode_ping(
    node_name: str, max_count: int | None = None, verbose: bool = False, skip_cache: bool = False
) -> bool:
    """Ping a node once a second, `max_count` times (default: without end).

    Returns False if the node is unknown or does not answer. Raises ROSNodeIOException.
    """
    uri = get_api_uri(Master(_OWN_NAME), node_name)
    if uri is None:
        sys.stderr.write(f"cannot ping [{node_name}]: unknown node\n")
        return False
    if verbose:
        print(f"pinging {node_name} with a timeout of {NODE_TIMEOUT_S}s")
    count = 0
    while True:
        try:
            reply_s = node.loop.call(ping(node_name, uri))
        except RostetherError:
            sys.stderr.write(f"connection to [{node_name}] failed\n")
            return False
        if verbose:
            print(f"xmlrpc reply from {uri}\ttime={reply_s * 1000:f}ms")
        count += 1
        if max_count and count >= max_count:
            return True
        time.sleep(PING_INTERVAL_S)


def rosnode_ping_all(verbose: bool = False, skip_cache: bool = False) -> tuple[list[str], list[str]]:
    """Return the nodes that answer, and those that do not. Raises ROSNodeIOException."""
    answers = {name: rosnode_ping(name, max_count=1, verbose=verbose) for name in get_node_names()}
    return [name for name in answers if answers[name]], [name for name in answers if not answers[name]]


def kill_nodes(node_names: Iterable[str]) -> tuple[list[str], list[str]]:
    """Ask nodes to shut down; return the nodes that were asked, and the unknown ones.

    Raises ROSNodeIOException.
    """
    master = Master(_OWN_NAME)
    asked: list[str] = []
    unknown: list[str] = []
    for name in node_names:
        uri = get_api_uri(master, name)
        if uri is None:
            unknown.append(name)
            continue
        asked.append(name)
        # A node that ends immediately does not answer.
        with suppress(RostetherError):
            node.loop.call(_ask_to_end(name, uri))
    return asked, unknown


def cleanup_master_blacklist(master: Master, blacklist: Iterable[str]) -> None:
    """Unregister all topics and services of nodes. Raises MasterException, ROSException."""
    publishers, subscribers, services = master.getSystemState()
    for name in blacklist:
        print("Unregistering", name)
        uri = get_api_uri(master, name)
        own = Master(name)
        for topic in (topic for topic, nodes in publishers if name in nodes):
            own.unregisterPublisher(topic, uri)
        for topic in (topic for topic, nodes in subscribers if name in nodes):
            own.unregisterSubscriber(topic, uri)
        for service in (service for service, nodes in services if name in nodes):
            own.unregisterService(service, master.lookupService(service))


def rosnode_listnodes(namespace: str | None = None, list_uri: bool = False, list_all: bool = False) -> None:
    """Print the names of nodes, their URIs, or both. Raises ROSNodeIOException."""
    master = Master(_OWN_NAME)
    for name in sorted(get_node_names(namespace)):
        uri = (get_api_uri(master, name) or "unknown address") if list_uri or list_all else ""
        print(f"{uri} \t{name}" if list_all else uri or name)


def get_node_info_description(node_name: str) -> str:
    """Return a node's topics and services as text. Raises ROSNodeIOException."""
    state = _state()
    types = dict(Master(_OWN_NAME).getPublishedTopics("/"))
    text = f"Node [{node_name}]"
    for title, table in zip(("Publications", "Subscriptions", "Services"), state, strict=True):
        lines = [
            f" * {name}" + ("" if title == "Services" else f" [{types.get(name, 'unknown type')}]")
            for name in sorted(name for name, nodes in table if node_name in nodes)
        ]
        text += f"\n{title}: \n" + "\n".join(lines) + "\n" if lines else f"\n{title}: None\n"
    return text


def _state() -> list[list[tuple[str, list[str]]]]:
    with master_required(ROSNodeIOException):
        return [[(name, nodes) for name, nodes in table] for table in Master(_OWN_NAME).getSystemState()]


def _machines() -> list[tuple[str, str]]:
    master = Master(_OWN_NAME)
    found = []
    for name in get_node_names():
        try:
            found.append((name, parse_rpc_uri(master.lookupNode(name)).host))
        except (MasterException, ConfigError):
            continue
    return found


async def _ask_to_end(name: str, uri: str) -> None:
    async with node_client(name, uri) as peer:
        await ask(peer, "shutdown", "user request")
