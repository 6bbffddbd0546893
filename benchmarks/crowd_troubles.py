"""A faulty TCP device: it sends no valid frame, or announces new topics all the time.

    crowd_troubles.py PORT KIND BYTES_PER_S   prints a line, starts at a line on stdin, runs until killed

KIND is noise (random bytes), headers (bytes that look like the beginnings of frames) or announcements (the
topics of a new board each time). Prints at the end of each second how many bytes it wrote, which
shows that all of them were read.
"""

from __future__ import annotations

import itertools
import os
import select
import socket
import sys
import time
from collections.abc import Iterator

from benchmarks.crowd_devices import TIME_REQUEST, TOPIC_REQUEST
from benchmarks.flood_device import announcement, connect
from rostether.rosserial.frame import encode_frame

CHUNK_BYTES = 64 * 1024
TYPES = ("std_msgs/String", "std_msgs/UInt64", "sensor_msgs/Imu", "geometry_msgs/Twist")
BOARDS, TOPICS = 1000, 16
FIRST_ID = 125
PUBLISHER = 0


def noise() -> Iterator[bytes]:
    """Yield random bytes."""
    block = os.urandom(16 * CHUNK_BYTES)
    for index in itertools.count():
        at = index % 16 * CHUNK_BYTES
        yield block[at : at + CHUNK_BYTES]


def headers() -> Iterator[bytes]:
    """Yield beginnings of frames that never end."""
    return itertools.repeat(
        b"".join(
            encode_frame(FIRST_ID + number % 250, bytes(number % 60))[:7] + b"\xff\xfe"
            for number in range(CHUNK_BYTES // 9)
        )
    )


def announcements() -> Iterator[bytes]:
    """Yield the topics of different boards, one chunk each; created in advance, so that they cost no time."""
    frames = (
        announcement(FIRST_ID + number % 200, PUBLISHER, f"storm{number}", TYPES[number // 16 % len(TYPES)])
        for number in range(BOARDS * TOPICS)
    )
    return itertools.cycle([b"".join(itertools.islice(frames, TOPICS)) for _ in range(BOARDS)])


KINDS = {"noise": noise, "headers": headers, "announcements": announcements}


def write_paced(line: socket.socket, chunks: Iterator[bytes], bytes_per_s: float) -> None:
    """Write at a rate, or as fast as it is read; read and answer the host's requests."""
    began_s = told_s = time.monotonic()
    written = 0
    for chunk in chunks:
        while (early_s := began_s + written / bytes_per_s - time.monotonic()) > 0:
            ready, _, _ = select.select([line], [], [], early_s)
            if ready and TOPIC_REQUEST in line.recv(65536):
                line.sendall(TIME_REQUEST)
        line.sendall(chunk)
        written += len(chunk)
        if time.monotonic() > told_s + 1.0:
            told_s = time.monotonic()
            print(written, flush=True)


def main(arguments: list[str]) -> None:
    """Send to the host until ended."""
    port, kind, bytes_per_s = int(arguments[0]), arguments[1], float(arguments[2])
    line = connect(port)
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    chunks = KINDS[kind]()
    print("ready", flush=True)
    sys.stdin.readline()
    write_paced(line, chunks, bytes_per_s)


if __name__ == "__main__":
    main(sys.argv[1:])
