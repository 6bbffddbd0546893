"""TCP devices in one program: after the topic request, each publishes a std_msgs/String at HZ.

talker_device.py PORT COUNT HZ
"""

from __future__ import annotations

import selectors
import socket
import sys
import time

from benchmarks.flood_device import PAYLOADS, PUBLISHER_ID, announcement, connect
from rostether.rosserial.frame import encode_frame


def main(arguments: list[str]) -> None:
    """Serve the devices without end."""
    announcements = announcement(PUBLISHER_ID, 0, "flood", "std_msgs/String")
    message = encode_frame(PUBLISHER_ID, PAYLOADS["std_msgs/String"])
    selector = selectors.DefaultSelector()
    lines = [connect(int(arguments[0])) for _ in range(int(arguments[1]))]
    for line in lines:
        selector.register(line, selectors.EVENT_READ)
    asked: set[socket.socket] = set()
    period_s = 1 / float(arguments[2])
    due = time.monotonic()
    while True:
        for key, _ in selector.select(max(0.0, due - time.monotonic())):
            asking = key.fileobj
            assert isinstance(asking, socket.socket)
            received = asking.recv(65536)
            if not received:
                return
            if b"\xff\xfe\x00\x00\xff\x00\x00\xff" in received:
                asking.sendall(encode_frame(10, bytes(8)) + announcements + message)
                asked.add(asking)
        if time.monotonic() >= due:
            due += period_s
            for line in asked:
                line.sendall(message + encode_frame(10, bytes(8)))


if __name__ == "__main__":
    main(sys.argv[1:])
