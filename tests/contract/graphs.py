"""Shared by the contract tests of all graphs: types, a collector of messages, and functions that wait."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from rostether.graph.ports import Graph, Snapshot
from rostether.msgdef.interface import MessageType, ServiceType

STRING = MessageType("std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data\n")
BOOL = MessageType("std_msgs/Bool", "8b94c1b53db61fb6aed406028ad6332a", "bool data\n")
SET_BOOL = ServiceType(
    "std_srvs/SetBool",
    "09fb03525b03e7ea1fd3992bafd87e16",
    MessageType("std_srvs/SetBoolRequest", "8b94c1b53db61fb6aed406028ad6332a", "bool data\n"),
    MessageType(
        "std_srvs/SetBoolResponse", "937c9679a518e3a18d831e57125ea522", "bool success\nstring message\n"
    ),
)
EMPTY = ServiceType(
    "std_srvs/Empty",
    "d41d8cd98f00b204e9800998ecf8427e",
    MessageType("std_srvs/EmptyRequest", "d41d8cd98f00b204e9800998ecf8427e"),
    MessageType("std_srvs/EmptyResponse", "d41d8cd98f00b204e9800998ecf8427e"),
)
ADD_DIAGNOSTICS = ServiceType(
    "diagnostic_msgs/AddDiagnostics",
    "e6ac9bbde83d0d3186523c3687aecaee",
    MessageType(
        "diagnostic_msgs/AddDiagnosticsRequest",
        "c26cf6e164288fbc6050d74f838bcdf0",
        "string load_namespace\n",
    ),
    MessageType(
        "diagnostic_msgs/AddDiagnosticsResponse",
        "937c9679a518e3a18d831e57125ea522",
        "bool success\nstring message\n",
    ),
)
TRUE, FALSE = b"\1", b"\0"


def string(text: str) -> bytes:
    """Return a serialized std_msgs/String."""
    encoded = text.encode()
    return len(encoded).to_bytes(4, "little") + encoded


def answer(text: str = "", *, success: bool = True) -> bytes:
    """Return a serialized response of SetBool and of AddDiagnostics."""
    return (TRUE if success else FALSE) + string(text)


async def answer_set_bool(request: bytes) -> bytes:
    """Handle a SetBool request: `success` is the request's `data`."""
    return answer("done", success=request == TRUE)


@dataclass
class Inbox:
    """Collects what a subscriber receives."""

    payloads: list[bytes] = field(default_factory=list)
    headers: list[dict[str, str]] = field(default_factory=list)

    def store(self, payloads: Sequence[bytes]) -> None:
        """Store messages, as `on_messages`."""
        self.payloads.extend(payloads)

    def store_header(self, fields: Mapping[str, str]) -> None:
        """Store the fields of a connection header, as `on_connection`."""
        self.headers.append(dict(fields))


async def wait_for_snapshot(
    graph: Graph, condition: Callable[[Snapshot], object], timeout_s: float = 60.0
) -> Snapshot:
    """Wait until the graph's snapshot meets a condition, and return it."""
    deadline_s = time.monotonic() + timeout_s
    while not condition(snapshot := await graph.snapshot()):
        if time.monotonic() > deadline_s:
            raise AssertionError(f"the condition never became true of {snapshot}")
        await asyncio.sleep(0.005)
    return snapshot


async def wait_for_service(graph: Graph, service: str) -> None:
    """Wait until a node's snapshot has a service."""
    await wait_for_snapshot(graph, lambda snapshot: service in snapshot.services)


async def wait_for_nodes(*graphs: Graph) -> None:
    """Wait until every node's snapshot has all nodes."""
    names = {graph.node_name for graph in graphs}
    for graph in graphs:
        await wait_for_snapshot(graph, lambda snapshot: names <= set(snapshot.nodes))
