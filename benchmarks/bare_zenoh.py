"""From zenoh to a TCP socket and back without a bridge: the time of zenoh, Python and the system.

bare_zenoh.py DEVICE_PORT ZENOH_PORT   prints a line when it listens, ends with its device
"""

from __future__ import annotations

import json
import socket
import sys

import zenoh

IN, OUT = "bench/in", "bench/out"


def main(device_port: str, zenoh_port: str) -> None:
    """Pass bytes on until the device closes the connection."""
    configuration = zenoh.Config()
    for path, value in (
        ("mode", '"router"'),
        ("listen/endpoints", json.dumps([f"tcp/127.0.0.1:{zenoh_port}"])),
        ("scouting/multicast/enabled", "false"),
        ("timestamping/enabled", "true"),
    ):
        configuration.insert_json5(path, value)
    with zenoh.open(configuration) as session:
        listener = socket.create_server(("127.0.0.1", int(device_port)))
        print("serving", flush=True)
        device, _ = listener.accept()
        device.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        publisher = session.declare_publisher(OUT)

        def take(sample: zenoh.Sample) -> None:
            device.sendall(sample.payload.to_bytes())

        session.declare_subscriber(IN, zenoh.handlers.Callback(take, indirect=False))
        while data := device.recv(65536):
            publisher.put(data)


if __name__ == "__main__":
    main(*sys.argv[1:])
