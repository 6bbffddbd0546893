"""A TCP device that only sends or counts: its frames are created before the measurement.

    flood_device.py PORT send TYPE COUNT   announces a publisher of TYPE on `flood`, waits for a line on
                                           stdin, then sends COUNT frames and prints seconds
    flood_device.py PORT sink COUNT        announces a std_msgs/String subscriber on `flood`, prints the count

A separate program with blocking sockets, so that only its bytes cost the bridge time.
"""

from __future__ import annotations

import contextlib
import select
import socket
import struct
import sys
import time

from rostether.msgdef.registry import Registry
from rostether.rosserial.frame import encode_frame

PUBLISHER_ID, SUBSCRIBER_ID = 125, 100
BUFFER_BYTES = 65535
BATCH = 400
REGISTRY = Registry()
PAYLOADS = {
    "std_msgs/String": struct.pack("<I", 60)
    + b"64 bytes of text, its length included, as a sensor reports it.."[:60],
    "sensor_msgs/Imu": struct.pack("<IIII", 1, 2, 3, 4) + b"imu0" + bytes(296),
    "sensor_msgs/CompressedImage": struct.pack("<IIII", 1, 2, 3, 4)
    + b"cam0"
    + struct.pack("<I4sI", 4, b"jpeg", 4064)
    + bytes(4064),
}


def announcement(topic_id: int, role: int, topic: str, type_name: str) -> bytes:
    """Return the TopicInfo frame of one endpoint; role 0 is a publisher, 1 a subscriber."""
    body = struct.pack("<H", topic_id)
    for text in (topic, type_name, REGISTRY.message_type(type_name).md5sum):
        body += struct.pack("<I", len(text)) + text.encode()
    return encode_frame(role, body + struct.pack("<i", BUFFER_BYTES))


def connect(port: int) -> socket.socket:
    """Connect as soon as the host listens."""
    while True:
        with contextlib.suppress(ConnectionRefusedError):
            return socket.create_connection(("127.0.0.1", port))
        time.sleep(0.005)


def answer_requests(line: socket.socket, announcements: bytes, received: bytes) -> None:
    """Announce the topics when requested, and request the time as a board does."""
    if b"\xff\xfe\x00\x00\xff\x00\x00\xff" in received:
        line.sendall(encode_frame(10, bytes(8)) + announcements)


def send(line: socket.socket, type_name: str, count: int) -> None:
    """Announce, wait for a line on stdin, flood."""
    frame = encode_frame(PUBLISHER_ID, PAYLOADS[type_name])
    announcements = announcement(PUBLISHER_ID, 0, "flood", type_name)
    while True:
        ready, _, _ = select.select([line, sys.stdin], [], [])
        if line in ready:
            answer_requests(line, announcements, line.recv(65536))
        if sys.stdin in ready:
            sys.stdin.readline()
            break
    whole, rest = divmod(count, BATCH)
    batch = frame * BATCH
    started = time.perf_counter()
    for _ in range(whole):
        line.sendall(batch)
    line.sendall(frame * rest)
    print(f"{time.perf_counter() - started:.6f}", flush=True)
    while line.recv(65536):
        pass


def sink(line: socket.socket, count: int) -> None:
    """Announce, count the frames of the topic until all have arrived, or for 3 s of silence."""
    announcements = announcement(SUBSCRIBER_ID, 1, "flood", "std_msgs/String")
    header = encode_frame(SUBSCRIBER_ID, bytes(64))[:7]
    tail = b""
    frames = 0
    started = last = 0.0
    line.settimeout(3.0)
    while frames < count:
        try:
            chunk = line.recv(1 << 20)
        except TimeoutError:
            if started:
                break
            continue
        if not frames:
            answer_requests(line, announcements, chunk)
        window = tail + chunk
        found = window.count(header)
        tail = window[-6:]
        if found:
            last = time.perf_counter()
            started = started or last
            frames += found
    print(f"{frames} {last - started:.6f}", flush=True)


def main(arguments: list[str]) -> None:
    """Run the mode that the arguments name."""
    line = connect(int(arguments[0]))
    if arguments[1] == "send":
        send(line, arguments[2], int(arguments[3]))
    else:
        sink(line, int(arguments[2]))


if __name__ == "__main__":
    main(sys.argv[1:])
