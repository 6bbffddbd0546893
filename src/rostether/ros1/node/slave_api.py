"""The Slave API: the requests of the master and of other nodes to a node.

Every method returns `[code, status message, value]`: 1 is success, 0 failure, -1 the caller's error.
Source: https://wiki.ros.org/ROS/Slave_API
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Protocol

from rostether.ros1.node.publication import Publication
from rostether.ros1.node.subscription import Subscription
from rostether.ros1.tcpros_connection import ConnectionRecord
from rostether.ros1.xmlrpc_methods import Dispatch
from rostether.xmlrpc.values import MAX_INT, XmlRpcValue

Answer = list[XmlRpcValue]


class SlaveNode(Protocol):
    """What the API needs of a node."""

    @property
    def node_name(self) -> str:
        """The node's name."""

    @property
    def node_uri(self) -> str:
        """The URI of its XML-RPC server."""

    @property
    def master_uri(self) -> str:
        """The URI of its master."""

    @property
    def tcpros_address(self) -> tuple[str, int]:
        """Host and port for TCPROS connections to it."""

    @property
    def publications(self) -> Iterable[Publication]:
        """The node's publications."""

    @property
    def subscriptions(self) -> Iterable[Subscription]:
        """The node's subscriptions."""

    def set_publishers(self, topic: str, uris: list[str]) -> None:
        """Apply the master's list of a topic's publishers."""

    def update_param(self, name: str, value: XmlRpcValue) -> bool:
        """Apply a parameter's new value; return False if it is not watched."""

    def shut_down(self, reason: str) -> None:
        """Leave the graph soon."""


def slave_dispatch(node: SlaveNode) -> Dispatch:
    """Return the methods of a node's XML-RPC server, by their names."""
    api = _SlaveApi(node)
    return {name: getattr(api, name) for name in vars(_SlaveApi) if not name.startswith("_")}


class _SlaveApi:
    """Its public methods are those of the API, with the same names."""

    # ruff: noqa: N802
    def __init__(self, node: SlaveNode) -> None:
        self._node = node

    def getBusStats(self, _caller_id: str) -> Answer:
        publications: list[XmlRpcValue] = [
            [
                each.topic,
                min(each.byte_count, MAX_INT),
                [[*_counters(c.record), True] for c in each.connections],
            ]
            for each in self._node.publications
        ]
        # -1: the publisher's dropped messages are unknown.
        subscriptions: list[XmlRpcValue] = [
            [each.topic, [[*_counters(c.record), -1, True] for c in each.connections]]
            for each in self._node.subscriptions
        ]
        return [1, "", [publications, subscriptions, []]]

    def getBusInfo(self, _caller_id: str) -> Answer:
        records = [c.record for each in self._node.publications for c in each.connections]
        records += [c.record for each in self._node.subscriptions for c in each.connections]
        return [
            1,
            "bus info",
            [[r.id, r.peer, r.direction, "TCPROS", r.topic, True, r.description] for r in records],
        ]

    def getMasterUri(self, _caller_id: str) -> Answer:
        return [1, self._node.master_uri, self._node.master_uri]

    def getUri(self, _caller_id: str) -> Answer:
        return [1, "", self._node.node_uri]

    def getName(self, _caller_id: str) -> Answer:
        return [1, "", self._node.node_name]

    def getPid(self, _caller_id: str) -> Answer:
        return [1, "", os.getpid()]

    def getPublications(self, _caller_id: str) -> Answer:
        return [1, "publications", [[each.topic, each.type.name] for each in self._node.publications]]

    def getSubscriptions(self, _caller_id: str) -> Answer:
        types = {each.topic: each.type.name for each in self._node.subscriptions}
        return [1, "subscriptions", [[topic, name] for topic, name in types.items()]]

    def paramUpdate(self, _caller_id: str, key: str, value: XmlRpcValue) -> Answer:
        if not isinstance(key, str):
            return [-1, "parameter_key must be a string", 0]
        return [1, "", 0] if self._node.update_param(key, value) else [-1, "not subscribed", 0]

    def publisherUpdate(self, _caller_id: str, topic: str, publishers: XmlRpcValue) -> Answer:
        if not isinstance(topic, str) or not isinstance(publishers, list):
            return [-1, "topic must be a string and publishers a list", 0]
        self._node.set_publishers(topic, [uri for uri in publishers if isinstance(uri, str)])
        return [1, "", 0]

    def requestTopic(self, _caller_id: str, topic: str, protocols: XmlRpcValue) -> Answer:
        if topic not in (each.topic for each in self._node.publications):
            return [-1, f"Not a publisher of [{topic}]", []]
        if not isinstance(protocols, list) or not all(isinstance(each, list) and each for each in protocols):
            return [-1, "protocols must be a list of lists that begin with a protocol's name", []]
        if any(each[0] == "TCPROS" for each in protocols if isinstance(each, list)):
            host, port = self._node.tcpros_address
            return [1, f"ready on {host}:{port}", ["TCPROS", host, port]]
        return [0, "no supported protocol implementations: this node speaks TCPROS", []]

    def shutdown(self, caller_id: str, message: str = "") -> Answer:
        self._node.shut_down(f"{caller_id} requested a shutdown{message and f': {message}'}")
        return [1, "shutdown", 0]


def _counters(record: ConnectionRecord) -> list[XmlRpcValue]:
    return [record.id, min(record.byte_count, MAX_INT), min(record.message_count, MAX_INT)]
