"""The time to encode, decode and check one message, compared with rosbags in the same run.

`compare()` returns the rows; python -m benchmarks.serde_codec prints them.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rostether.serde.codec import Codec

ROUND_S = 0.05
ROUNDS = 5
BATCH = 100
MESSAGES: dict[str, dict[str, Any]] = {
    "std_msgs/String": {"data": "a" * 60},
    "sensor_msgs/Imu": {"header": {"frame_id": "imu_link"}, "orientation": {"w": 1.0}},
}
DECODE_ONE_STRING = {
    "rostether": (
        "from rostether.msgdef.registry import Registry\n"
        "from rostether.serde.store import TypeStore\n"
        "TypeStore(Registry()).codec('std_msgs/String').decode(bytes(4))"
    ),
    "rosbags": (
        "from rosbags.typesys import Stores, get_typestore\n"
        "get_typestore(Stores.ROS1_NOETIC).deserialize_ros1(bytes(4), 'std_msgs/msg/String')"
    ),
    "python": "",
}


@dataclass(frozen=True, slots=True)
class Row:
    """One operation; `rosbags_ns` is None if rosbags has no such operation."""

    operation: str
    rostether_ns: float
    rosbags_ns: float | None


@dataclass(frozen=True, slots=True)
class Start:
    """A process that decodes one message and ends."""

    library: str
    duration_s: float
    resident_mb: float


def compare() -> list[Row]:
    """Measure both libraries in turns."""
    from rosbags.typesys import Stores, get_typestore

    from rostether.msgdef.registry import Registry
    from rostether.serde.store import TypeStore

    store, rosbags = TypeStore(Registry()), get_typestore(Stores.ROS1_NOETIC)
    rows: list[Row] = []
    for name, fields in MESSAGES.items():
        rows += _compare_type(store.codec(name), fields, rosbags)
    return rows


def _compare_type(codec: Codec, fields: dict[str, Any], rosbags: Any) -> list[Row]:
    name, rosbags_name = codec.type_name, codec.type_name.replace("/", "/msg/")
    message = codec.conform(fields)
    payload = codec.encode(message)
    rosbags_message = rosbags.deserialize_ros1(payload, rosbags_name)
    assert bytes(rosbags.serialize_ros1(rosbags_message, rosbags_name)) == payload
    batch = [payload] * BATCH
    return [
        Row(
            f"{name} encode",
            best_ns(lambda: codec.encode(message)),
            best_ns(lambda: rosbags.serialize_ros1(rosbags_message, rosbags_name)),
        ),
        Row(
            f"{name} decode",
            best_ns(lambda: codec.decode(payload)),
            best_ns(lambda: rosbags.deserialize_ros1(payload, rosbags_name)),
        ),
        Row(f"{name} check", best_ns(lambda: codec.layout.accepts_all(batch)) / BATCH, None),
    ]


def starts() -> list[Start]:
    """Measure the cost of the import of each library, up to the first decoded message."""
    return [_start(library, code) for library, code in DECODE_ONE_STRING.items()]


def best_ns(call: Callable[[], object]) -> float:
    """Return the time of one call in the best of several rounds: the others were disturbed."""
    call()
    best_s = float("inf")
    for _ in range(ROUNDS):
        count, start_s = 0, time.perf_counter()
        while (elapsed_s := time.perf_counter() - start_s) < ROUND_S:
            for _ in range(BATCH):
                call()
            count += BATCH
        best_s = min(best_s, elapsed_s / count)
    return best_s * 1e9


def _start(library: str, code: str) -> Start:
    # ru_maxrss would be this process's own: it outlives the exec.
    report = "\nprint(next(line for line in open('/proc/self/status') if 'VmRSS' in line).split()[1])"
    command = [sys.executable, "-c", code + report]
    best_s, resident_kb = float("inf"), 0
    with tempfile.TemporaryDirectory() as folder:
        # An installed package is compiled once, a source tree perhaps never.
        environment = os.environ | {"PYTHONPYCACHEPREFIX": folder, "PYTHONDONTWRITEBYTECODE": ""}
        for _ in range(ROUNDS):
            start_s = time.perf_counter()
            done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
            best_s = min(best_s, time.perf_counter() - start_s)
            resident_kb = int(done.stdout)
    return Start(library, best_s, resident_kb / 1024)


if __name__ == "__main__":
    for row in compare():
        beside = "" if row.rosbags_ns is None else f", rosbags {row.rosbags_ns:,.0f} ns"
        ratio = "" if row.rosbags_ns is None else f" ({row.rosbags_ns / row.rostether_ns:.1f} times as long)"
        print(f"{row.operation}: {row.rostether_ns:,.0f} ns{beside}{ratio}")
    for start in starts():
        print(f"decode one String, {start.library}: {start.duration_s:.3f} s, {start.resident_mb:.0f} MB")
