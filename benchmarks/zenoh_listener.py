"""A plain subscriber over zenoh: it counts messages in rmw_zenoh's form.

zenoh_listener.py ZENOH_PORT TOPIC COUNT   prints a line when it finds a publisher, then "count seconds"

Samples without rmw_zenoh's attachment are not counted: a node of ROS 2 would drop them.
"""

from __future__ import annotations

import sys
import threading
import time

import zenoh

from rostether.ros2.zenoh.thread_state import keep_thread_state

ATTACHMENT_BYTES = 33
IDLE_S = 3.0
FOUND_S = 20.0


def open_session(zenoh_port: str) -> zenoh.Session:
    """Open a session that connects only to the bridge's port."""
    configuration = zenoh.Config()
    for path, value in (
        ("mode", '"peer"'),
        ("connect/endpoints", f'["tcp/127.0.0.1:{zenoh_port}"]'),
        ("listen/endpoints", '["tcp/127.0.0.1:0"]'),
        ("scouting/multicast/enabled", "false"),
        ("timestamping/enabled", "true"),
    ):
        configuration.insert_json5(path, value)
    return zenoh.open(configuration)


def wait_for(session: zenoh.Session, kind: str, topic: str) -> str:
    """Wait for the token of a publisher or subscriber; return the key of its samples. Raises RuntimeError."""
    ends_s = time.monotonic() + FOUND_S
    while time.monotonic() < ends_s:
        for reply in session.liveliness().get(f"@ros2_lv/0/*/*/*/{kind}/*/*/*/%{topic}/**", timeout=1.0):
            if reply.ok is not None:
                parts = str(reply.ok.key_expr).split("/")
                return f"0/{topic}/{parts[10]}/{parts[11]}"
        time.sleep(0.05)
    raise RuntimeError(f"there is no token for /{topic}")


def main(zenoh_port: str, topic: str, count: str) -> None:
    """Count until all have arrived, or none for a while."""
    wanted = int(count)
    total = 0
    first_s = last_s = 0.0
    done = threading.Event()

    def take(sample: zenoh.Sample) -> None:
        nonlocal total, first_s, last_s
        keep_thread_state()
        attachment = sample.attachment
        if attachment is None or len(attachment) != ATTACHMENT_BYTES or not sample.payload.to_bytes():
            return
        total += 1
        last_s = time.perf_counter()
        first_s = first_s or last_s
        if total >= wanted:
            done.set()

    session = open_session(zenoh_port)
    key = wait_for(session, "MP", topic)
    session.declare_subscriber(key, zenoh.handlers.Callback(take, indirect=False))
    time.sleep(0.5)
    print("there", flush=True)
    started_s = time.perf_counter()
    while not done.wait(0.1):
        silent_s = time.perf_counter() - (last_s or started_s + FOUND_S)
        if silent_s > IDLE_S:
            break
    print(f"{total} {last_s - first_s:.6f}", flush=True)
    session.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
