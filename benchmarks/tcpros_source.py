"""The two peers of the bare relay: a source of TCPROS messages, and a sink that counts them.

tcpros_source.py PORT TYPE COUNT   connects, waits for a line on stdin, sends COUNT messages
tcpros_source.py PORT sink COUNT   connects, counts 64-byte messages, prints "count seconds"
"""

from __future__ import annotations

import struct
import sys
import time

from benchmarks.flood_device import BATCH, PAYLOADS, connect


def main(arguments: list[str]) -> None:
    """Run the mode that the arguments name."""
    line = connect(int(arguments[0]))
    count = int(arguments[2])
    if arguments[1] == "sink":
        total, started, last = 0, 0.0, 0.0
        line.settimeout(3.0)
        try:
            while total < count * 68:
                size = len(line.recv(1 << 20))
                last = time.perf_counter()
                started = started or last
                total += size
        except TimeoutError:
            pass
        print(f"{total // 68} {last - started:.6f}", flush=True)
        return
    payload = PAYLOADS[arguments[1]]
    message = struct.pack("<I", len(payload)) + payload
    print("connected", flush=True)
    sys.stdin.readline()
    time.sleep(0.5)
    whole, rest = divmod(count, BATCH)
    batch = message * BATCH
    for _ in range(whole):
        line.sendall(batch)
    line.sendall(message * rest)
    sys.stdin.readline()


if __name__ == "__main__":
    main(sys.argv[1:])
