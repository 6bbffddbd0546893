"""Prints the transform of a frame once, with roslibpy's TFClient, which uses tf2_web_republisher's service.

roslibpy_tf.py PORT
"""

from __future__ import annotations

import json
import sys
import threading

import roslibpy
import roslibpy.tf

arrived = threading.Event()
client = roslibpy.Ros("127.0.0.1", int(sys.argv[1]))
client.run(60)


def print_first(transform: dict[str, object]) -> None:
    """Print the first transform."""
    if not arrived.is_set():
        print(json.dumps(transform), flush=True)
        arrived.set()


tf = roslibpy.tf.TFClient(client, fixed_frame="/world", topic_timeout=60_000.0)
tf.subscribe("/arm", print_first)
has_arrived = arrived.wait(60)
client.terminate()
sys.exit(0 if has_arrived else 1)
