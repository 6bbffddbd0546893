"""The limit for comparison: blocking Python that copies bytes in TCPROS form from socket to socket.

    bare_relay.py MASTER_URI out PORT TOPIC TYPE   a publisher of TOPIC that copies the bytes received on PORT
    bare_relay.py MASTER_URI in PORT TOPIC TYPE    a subscriber of TOPIC that copies to the client of PORT

It decodes nothing, checks nothing and serves one peer.
"""

from __future__ import annotations

import socket
import struct
import sys
import threading
import xmlrpc.client
from typing import Any
from xmlrpc.server import SimpleXMLRPCServer

from rostether.msgdef.registry import Registry

CHUNK_BYTES = 1 << 18


def listen(port: int = 0) -> socket.socket:
    """Listen on loopback."""
    return socket.create_server(("127.0.0.1", port))


def header(**fields: str) -> bytes:
    """Return a connection header with its length."""
    body = b"".join(
        struct.pack("<I", len(name) + 1 + len(value)) + f"{name}={value}".encode()
        for name, value in fields.items()
    )
    return struct.pack("<I", len(body)) + body


def read_header(line: socket.socket) -> bytes:
    """Read one connection header."""
    (size,) = struct.unpack("<I", line.recv(4, socket.MSG_WAITALL))
    return line.recv(size, socket.MSG_WAITALL)


def copy(source: socket.socket, target: socket.socket) -> None:
    """Copy until the source ends."""
    buffer = memoryview(bytearray(CHUNK_BYTES))
    while size := source.recv_into(buffer):
        target.sendall(buffer[:size])


def slave(tcpros_port: int) -> str:
    """Serve the slave API for a subscriber; return its URI."""
    server = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False, allow_none=True)
    server.register_function(
        lambda caller, topic, protocols: (1, "ready", ["TCPROS", "127.0.0.1", tcpros_port]), "requestTopic"
    )
    server.register_function(lambda caller, topic, publishers: (1, "", 0), "publisherUpdate")
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{server.server_address[1]}/"


def relay_out(master: Any, port: int, topic: str, type_name: str) -> None:
    """Publish the bytes received on `port`, unchanged."""
    server, source_server = listen(), listen(port)
    message_type = Registry().message_type(type_name)
    master.registerPublisher("/bare_relay", topic, type_name, slave(server.getsockname()[1]))
    source, _ = source_server.accept()
    subscriber, _ = server.accept()
    read_header(subscriber)
    subscriber.sendall(
        header(
            callerid="/bare_relay",
            md5sum=message_type.md5sum,
            type=type_name,
            latching="0",
            message_definition=message_type.definition,
        )
    )
    copy(source, subscriber)


def relay_in(master: Any, port: int, topic: str, type_name: str) -> None:
    """Subscribe, and copy the messages to the client of `port`."""
    target_server = listen(port)
    target, _ = target_server.accept()
    publishers = master.registerSubscriber("/bare_relay", topic, type_name, slave(0))[2]
    slave_api: Any = xmlrpc.client.ServerProxy(publishers[0])
    _, _, (_, host, tcpros_port) = slave_api.requestTopic("/bare_relay", topic, [["TCPROS"]])
    publisher = socket.create_connection((host, tcpros_port))
    md5sum = Registry().message_type(type_name).md5sum
    publisher.sendall(
        header(callerid="/bare_relay", topic=topic, md5sum=md5sum, type=type_name, tcp_nodelay="1")
    )
    read_header(publisher)
    copy(publisher, target)


def main(arguments: list[str]) -> None:
    """Relay in the direction that the arguments name."""
    master: Any = xmlrpc.client.ServerProxy(arguments[0])
    relay = relay_out if arguments[1] == "out" else relay_in
    relay(master, int(arguments[2]), arguments[3], arguments[4])


if __name__ == "__main__":
    main(sys.argv[1:])
