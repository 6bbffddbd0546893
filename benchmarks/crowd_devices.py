"""Many TCP devices in one program: each publishes the time in ns at HZ, on a separate topic.

    crowd_devices.py PORT COUNT HZ MESSAGES

Each message is a std_msgs/UInt64, the time of writing on the machine's monotonic clock, so that a
receiver knows the delay. The program prints a line when all devices have received a topic request, and sends
after a line on stdin. Then it prints how late it sent the messages: p99 and the longest, in ms. The machine
causes this delay, and also delays the bridge.
The devices send at times spread evenly over the period, like independent boards. Their TCP
collects small messages until the last is acknowledged (no TCP_NODELAY), as on many boards.
"""

from __future__ import annotations

import selectors
import socket
import struct
import sys
import time

from benchmarks.flood_device import PUBLISHER_ID, announcement, connect
from rostether.rosserial.frame import encode_frame
from rostether.transports.descriptors import allow_many_descriptors

TOPIC_REQUEST = b"\xff\xfe\x00\x00\xff\x00\x00\xff"
TIME_REQUEST = encode_frame(10, bytes(8))
TIME_PERIOD_S = 2.5
TYPE = "std_msgs/UInt64"


def stamped() -> bytes:
    """Return a message with the current time."""
    return encode_frame(PUBLISHER_ID, struct.pack("<Q", time.monotonic_ns()))


class Crowd:
    """The devices."""

    def __init__(self, port: int, count: int) -> None:
        self.lines = [connect(port) for _ in range(count)]
        self._announcements = {
            line: announcement(PUBLISHER_ID, 0, f"crowd{number}", TYPE)
            for number, line in enumerate(self.lines)
        }
        self._selector = selectors.DefaultSelector()
        for line in self.lines:
            self._selector.register(line, selectors.EVENT_READ)
        self.asked: set[socket.socket] = set()
        self._time_due = time.monotonic()
        self._asks = 0

    def serve(self, until_s: float) -> None:
        """Answer the host's requests until `until_s`, and request the time as boards do."""
        while True:
            rest_s = until_s - time.monotonic()
            for key, _ in self._selector.select(max(rest_s, 0.0)):
                line = key.fileobj
                assert isinstance(line, socket.socket)
                if TOPIC_REQUEST in line.recv(65536):
                    line.sendall(TIME_REQUEST + self._announcements[line])
                    self.asked.add(line)
            while time.monotonic() >= self._time_due:
                # At different times: each board counts from its own start.
                self._time_due += TIME_PERIOD_S / len(self.lines)
                self._asks += 1
                line = self.lines[self._asks % len(self.lines)]
                if line in self.asked:
                    line.sendall(TIME_REQUEST)
            if time.monotonic() >= until_s:
                return


def main(arguments: list[str]) -> None:
    """Send all messages and print the delays; then keep the connections open until killed."""
    port, count, rate_hz, messages = (int(argument) for argument in arguments)
    allow_many_descriptors()
    crowd = Crowd(port, count)
    while len(crowd.asked) < count:
        crowd.serve(time.monotonic() + 0.05)
    print("ready", flush=True)
    readable = selectors.DefaultSelector()
    readable.register(sys.stdin, selectors.EVENT_READ)
    while not readable.select(0):
        crowd.serve(time.monotonic() + 0.05)
    began_s = time.monotonic()
    step_s = 1 / (rate_hz * count)
    late_s: list[float] = []
    for turn in range(messages * count):
        crowd.serve(began_s + turn * step_s)
        late_s.append(time.monotonic() - began_s - turn * step_s)
        crowd.lines[turn % count].sendall(stamped())
    late_s.sort()
    print(f"{late_s[len(late_s) * 99 // 100] * 1e3:.3f} {late_s[-1] * 1e3:.3f}", flush=True)
    while True:
        crowd.serve(time.monotonic() + 1.0)


if __name__ == "__main__":
    main(sys.argv[1:])
