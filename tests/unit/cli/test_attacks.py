"""`rostether serve` while peers send the most expensive requests: other peers get answers in time."""

from __future__ import annotations

import asyncio
import contextlib
import struct
import time
from pathlib import Path

from interop.ros1_peers import free_port
from programs import started
from rostether import Device
from rostether.ros1.xmlrpc_client import XmlRpcClient

# Without limits, each of these took 2 to 50 s.
LIMIT_S = 1.0
HEADER_BYTES = 1 << 20
MANY_FIELDS = struct.pack("<I", HEADER_BYTES) + (b"\1\0\0\0=" * HEADER_BYTES)[:HEADER_BYTES]
MANY_ATTRIBUTES = b"<methodCall " + b"".join(b'a%d="" ' % number for number in range(500_000)) + b"/>"
MANY_VALUES = (
    b"<methodCall><methodName>getPid</methodName><params>"
    + b"<param><value/></param>" * 500_000
    + b"</params></methodCall>"
)


def request(body: bytes) -> bytes:
    return (
        b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/xml\r\nContent-Length: %d\r\n\r\n"
        % len(body)
        + body
    )


async def attack(port: int, data: bytes, count: int) -> None:
    async def one() -> None:
        with contextlib.suppress(OSError):
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(data)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(reader.read(100), 60)
            writer.close()

    await asyncio.gather(*(one() for _ in range(count)))


def clock_s(pid: int) -> float:
    """Return the CPU time of a process, which a busy machine does not lengthen; without procfs, the time."""
    try:
        return int(Path(f"/proc/{pid}/schedstat").read_text().split()[0]) / 1e9
    except FileNotFoundError:
        return time.monotonic()


async def longest_answer_s(uri: str, pid: int, during: asyncio.Task[None]) -> float:
    client, longest_s = XmlRpcClient(uri), 0.0
    try:
        while not during.done():
            began_s = clock_s(pid)
            await client.call("getPid", "/bystander")
            longest_s = max(longest_s, clock_s(pid) - began_s)
            await asyncio.sleep(0.01)
    finally:
        await client.close()
    await during
    return longest_s


async def test_bystanders_are_answered_in_time() -> None:
    board_port, port = free_port(), free_port()
    async with started(
        "serve", f"tcp://:{board_port}?name=board", ROS_MASTER_URI=f"http://localhost:{port}"
    ) as serve:
        await serve.wait_for("Waiting for boards")
        uri = f"http://127.0.0.1:{port}/"
        async with Device(f"tcp://127.0.0.1:{board_port}") as device:
            device.publisher("count", "std_msgs/UInt32")
            await device.wait_connected(60.0)
            client = XmlRpcClient(uri)
            _, _, node = await client.call_status("lookupNode", "/x", "/board")
            node_client = XmlRpcClient(str(node))
            place: object = []
            async with asyncio.timeout(60):
                # The node registers before its topics.
                while not place:
                    _, _, place = await node_client.call_status("requestTopic", "/x", "/count", [["TCPROS"]])
            await node_client.close()
            await client.close()
            assert isinstance(place, list)
            for target, data, count in (
                (int(str(place[2])), MANY_FIELDS, 60),
                (port, request(MANY_ATTRIBUTES), 2),
                (port, request(MANY_VALUES), 2),
            ):
                attacking = asyncio.create_task(attack(target, data, count))
                assert await longest_answer_s(uri, serve.process.pid, attacking) < LIMIT_S
            assert device.connected
        assert "please report" not in serve.text
