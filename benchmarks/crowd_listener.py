"""Receives every message of crowd_devices.py over raw TCPROS connections; prints their delays.

    crowd_listener.py MASTER_URI COUNT MESSAGES

Prints a line when all connections are open; at the end: received, p50, p99 and the longest in ms.
"""

from __future__ import annotations

import selectors
import socket
import struct
import sys
import time
import xmlrpc.client
from typing import Any

from benchmarks.crowd_devices import TYPE
from rostether.msgdef.registry import Registry
from rostether.transports.descriptors import allow_many_descriptors

QUIET_S = 3.0


def subscribe(master: Any, topic: str, publisher: str, md5sum: str) -> socket.socket:
    """Connect to the publisher of a topic, and read its header."""
    uri = master.lookupNode("/crowd", publisher)[2]
    node: Any = xmlrpc.client.ServerProxy(uri)
    _, host, port = node.requestTopic("/crowd", topic, [["TCPROS"]])[2]
    line = socket.create_connection((host, port))
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    fields = {
        "callerid": "/crowd",
        "topic": topic,
        "type": TYPE,
        "md5sum": md5sum,
        "tcp_nodelay": "1",
    }
    pairs = [f"{key}={value}".encode() for key, value in fields.items()]
    body = b"".join(struct.pack("<I", len(pair)) + pair for pair in pairs)
    line.sendall(struct.pack("<I", len(body)) + body)
    size = struct.unpack("<I", line.recv(4, socket.MSG_WAITALL))[0]
    line.recv(size, socket.MSG_WAITALL)
    return line


def main(arguments: list[str]) -> None:
    """Listen until all messages have arrived, or no more arrive."""
    master_uri, count, messages = arguments[0], int(arguments[1]), int(arguments[2])
    allow_many_descriptors()
    selector = selectors.DefaultSelector()
    master: Any = xmlrpc.client.ServerProxy(master_uri)
    publishers = dict(master.getSystemState("/crowd")[2][0])
    md5sum = Registry().message_type(TYPE).md5sum
    for topic in (f"/crowd{number}" for number in range(count)):
        connection = subscribe(master, topic, publishers[topic][0], md5sum)
        selector.register(connection, selectors.EVENT_READ, bytearray())
    print("ready", flush=True)
    times_ns: list[int] = []
    last_s = float("inf")
    while len(times_ns) < count * messages and time.monotonic() < last_s + QUIET_S:
        for key, _ in selector.select(0.5):
            line = key.fileobj
            assert isinstance(line, socket.socket)
            chunk = line.recv(65536)
            now_ns = time.monotonic_ns()
            if not chunk:
                selector.unregister(line)
                continue
            last_s = now_ns / 1e9
            unread: bytearray = key.data
            unread += chunk
            while len(unread) >= 12:
                times_ns.append(now_ns - struct.unpack_from("<Q", unread, 4)[0])
                del unread[:12]
    times_ns.sort()
    p50, p99, longest = (
        times_ns[min(int(len(times_ns) * share), len(times_ns) - 1)] / 1e6 for share in (0.5, 0.99, 1.0)
    )
    print(f"{len(times_ns)} {p50:.3f} {p99:.3f} {longest:.3f}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
