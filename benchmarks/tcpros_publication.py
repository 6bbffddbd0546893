"""The TCPROS data path without a bridge: CPU and time per message, compared with a bare `sendall`.

python -m benchmarks.tcpros_publication [MESSAGES]

The peer is a process that only reads (or only writes) a socket, so that it is not the limit.
"""

from __future__ import annotations

import asyncio
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

from rostether.errors import GraphError
from rostether.graph.ports import Level
from rostether.msgdef.interface import MessageType
from rostether.ros1.node.publication import Publication
from rostether.ros1.node.publisher_connection import PublisherConnection
from rostether.ros1.tcpros_connection import ConnectionRecord, HandshakeProtocol, connect
from rostether.tcpros.handshake import subscriber_fields
from rostether.tcpros.header import encode_header
from rostether.tcpros.message_framing import MAX_MESSAGE_BYTES, encode_messages

BATCH = 500
PAYLOAD = bytes(64)
STRING = MessageType("std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data\n")
HEADER = encode_header(subscriber_fields("/chat", STRING, caller_id="/sink", tcp_nodelay=True))

SINK = """
import socket, sys
port, header, total = int(sys.argv[1]), bytes.fromhex(sys.argv[2]), int(sys.argv[3])
peer = socket.create_connection(("127.0.0.1", port))
peer.sendall(header)
buffer = bytearray(1 << 20)
while total > 0:
    size = peer.recv_into(buffer)
    if not size:
        break
    total -= size
peer.close()
"""

SOURCE = """
import socket, sys
port, count = int(sys.argv[1]), int(sys.argv[4])
header, batch = bytes.fromhex(sys.argv[2]), bytes.fromhex(sys.argv[3])
server = socket.create_server(("127.0.0.1", port))
print("ready", flush=True)
peer, _ = server.accept()
peer.recv(65536)
peer.sendall(header)
for _ in range(count):
    peer.sendall(batch)
peer.recv(1)
"""


@dataclass
class Run:
    """One measurement."""

    name: str
    messages: int
    wall_s: float
    cpu_s: float

    def __str__(self) -> str:
        return (
            f"{self.name:<28} {self.messages / self.wall_s:>12,.0f} messages/s "
            f"{self.cpu_s / self.messages * 1e6:>8.3f} us CPU a message"
        )


def bare_sendall(messages: int) -> Run:
    """Send the same bytes without TCPROS."""
    batch = encode_messages([PAYLOAD] * BATCH)
    with socket.create_server(("127.0.0.1", 0)) as server:
        sink = _start(SINK, str(server.getsockname()[1]), HEADER.hex(), str(messages // BATCH * len(batch)))
        peer, _ = server.accept()
        with peer:
            peer.recv(65536)
            wall_s, cpu_s = time.perf_counter(), time.process_time()
            for _ in range(messages // BATCH):
                peer.sendall(batch)
            sink.wait()
            return Run("bare sendall", messages, time.perf_counter() - wall_s, time.process_time() - cpu_s)


async def publication(messages: int) -> Run:
    """Publish batches to one subscriber; wait while it is behind."""
    topic = Publication("/chat", STRING, node_name="/bench", report=_fail)
    server = await asyncio.get_running_loop().create_server(
        lambda: HandshakeProtocol(topic.accept), "127.0.0.1", 0
    )
    total = messages * (4 + len(PAYLOAD))
    sink = _start(SINK, str(server.sockets[0].getsockname()[1]), HEADER.hex(), str(total))
    while not topic.connections:
        await asyncio.sleep(0.001)
    payloads = [PAYLOAD] * BATCH
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    for _ in range(messages // BATCH):
        if not topic.publish(payloads):
            await topic.drained(0.1)
    while topic.connections:
        await asyncio.sleep(0.001)
    run = Run("publication", messages, time.perf_counter() - wall_s, time.process_time() - cpu_s)
    sink.wait()
    server.close()
    if topic.dropped_count:
        raise SystemExit(f"{topic.dropped_count} messages lost")
    return run


async def subscription(messages: int) -> Run:
    """Receive batches from one publisher."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    batch = encode_messages([PAYLOAD] * BATCH)
    source = _start(SOURCE, str(port), HEADER.hex(), batch.hex(), str(messages // BATCH))
    assert source.stdout is not None
    source.stdout.readline()
    received = 0
    done = asyncio.Event()

    def take(payloads: Sequence[bytes]) -> None:
        nonlocal received
        received += len(payloads)
        if received >= messages:
            done.set()

    def accept(_: dict[str, str], transport: asyncio.Transport) -> PublisherConnection:
        record = ConnectionRecord(transport, peer="", topic="/chat", direction="i")
        return PublisherConnection(transport, record, take, MAX_MESSAGE_BYTES)

    wall_s, cpu_s = time.perf_counter(), time.process_time()
    connection = await connect("127.0.0.1", port, {"topic": "/chat", "md5sum": "*"}, accept)
    await done.wait()
    run = Run("subscription", messages, time.perf_counter() - wall_s, time.process_time() - cpu_s)
    assert isinstance(connection, PublisherConnection)
    connection.abort()
    source.kill()
    source.wait()
    source.stdout.close()
    return run


def _start(script: str, *arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", script, *arguments], stdout=subprocess.PIPE)


def _fail(_: Level, text: str) -> None:
    raise GraphError(text)


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 2_000_000
    runs = [bare_sendall(count), asyncio.run(publication(count)), asyncio.run(subscription(count))]
    for run in runs:
        print(run)
    print(f"publication / bare sendall: {runs[0].wall_s / runs[1].wall_s:.0%}")
