"""Round trips over a serial line of 115200 baud: zenoh, the bridge, an Uno that repeats, and back.

The Uno is simulated with its real firmware, and its UART has the bit rate of a real one: ten bits
a byte, and eight bytes of frame around each message.
"""

from __future__ import annotations

import asyncio
import os
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import zenoh

from benchmarks.round_trip import RoundTrips
from benchmarks.zenoh_listener import open_session, wait_for
from interop.ros1_peers import free_port
from rostether.firmware.build import build_sketch, find_board
from rostether.ros2.zenoh.attachment import Attachment

SKETCH = Path(__file__).parent / "firmware" / "repeat"
BAUD = 115_200
BITS_PER_BYTE = 10
FRAME_BYTES = 8
LOST_S = 2.0
ENDED_S = 5.0


def line_ms(payload_bytes: int) -> float:
    """Return the time of the line alone for a message and its echo."""
    return 2 * 1000 * (payload_bytes + FRAME_BYTES) * BITS_PER_BYTE / BAUD


def round_trips(payload_bytes: int, count: int) -> RoundTrips:
    """Measure round trips of String messages of this size, one after the other."""
    elf = asyncio.run(build_sketch(SKETCH, find_board("uno"))).elf
    port = free_port()
    times: list[float] = []
    with ExitStack() as stack:
        stack.enter_context(_serving(port, f"sim:{elf}?board=uno&name=repeating_board"))
        session = stack.enter_context(open_session(str(port)))
        came = threading.Event()

        def take(_: zenoh.Sample) -> None:
            came.set()

        session.declare_subscriber(
            wait_for(session, "MP", "out"), zenoh.handlers.Callback(take, indirect=False)
        )
        publisher = session.declare_publisher(wait_for(session, "MS", "in"))
        text = b"x" * (payload_bytes - 4)
        cdr = b"\0\1\0\0" + struct.pack("<I", len(text) + 1) + text + b"\0"
        time.sleep(1.0)
        for sequence in range(1, count + 1):
            came.clear()
            attachment = Attachment(sequence, time.time_ns(), bytes(16)).encode()
            started_s = time.perf_counter()
            publisher.put(cdr, attachment=attachment)
            if came.wait(LOST_S):
                times.append(time.perf_counter() - started_s)
            # Not in phase with the board's own work.
            time.sleep(0.003 + 0.0001 * (sequence % 17))
    return RoundTrips(count, tuple(sorted(times)))


@contextmanager
def _serving(port: int, address: str) -> Iterator[None]:
    override = f'listen/endpoints=["tcp/127.0.0.1:{port}"]'
    process = subprocess.Popen(
        [sys.executable, "-m", "rostether", "serve", "--ros2", "zenoh", "--zenoh-router", "always", address],
        env={**os.environ, "ROS_DOMAIN_ID": "0", "ZENOH_CONFIG_OVERRIDE": override},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        time.sleep(1.0)
        yield
    finally:
        process.terminate()
        try:
            process.wait(ENDED_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
