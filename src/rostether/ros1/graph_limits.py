"""The limits of a ROS graph's servers and connections that a user may want to set, with their reasons."""

from __future__ import annotations

from msgspec import Struct

from rostether.tcpros.header import MAX_HEADER_BYTES
from rostether.tcpros.message_framing import MAX_MESSAGE_BYTES
from rostether.xmlrpc.http_message import MAX_BODY_BYTES


class GraphLimits(Struct, frozen=True):
    """The limits of one server, or of one node.

    `body_bytes`: an XML-RPC request or answer. The largest in practice are whole parameter dumps, of a few
    MB.
    `xmlrpc_connections`: descriptors are commonly limited to 1024 a process, and a graph of hundreds of nodes
    keeps one or two open each. `xmlrpc_connections_per_host`: one machine runs many nodes, but must leave
    room for other machines; the programs of this machine need no such limit.
    `xmlrpc_request_s`: the time of the largest request over a slow radio link; slower ones are refused.
    `parameter_bytes`, `parameters_bytes`: the memory for the parameters of one call to the master, and for
    all parameters together. A few robot descriptions have a few MB; larger data belongs in files.
    `message_bytes`: a message, request or answer of a node: four times the largest in practice.
    `header_bytes`: a connection header, mostly its message definition; Debian's longest one is 20 KB.
    `header_s`: the time for receiving it. TCP retransmits a lost packet within 3 s.
    `tcpros_connections`, `tcpros_connections_per_host`: as for XML-RPC; one stays open for each subscriber.
    """

    body_bytes: int = MAX_BODY_BYTES
    xmlrpc_connections: int = 512
    xmlrpc_connections_per_host: int = 256
    xmlrpc_request_s: float = 60.0
    parameter_bytes: int = 64 * 1024 * 1024
    parameters_bytes: int = 256 * 1024 * 1024
    message_bytes: int = MAX_MESSAGE_BYTES
    header_bytes: int = MAX_HEADER_BYTES
    header_s: float = 10.0
    tcpros_connections: int = 768
    tcpros_connections_per_host: int = 384


DEFAULT_GRAPH_LIMITS = GraphLimits()
