"""A robot with many topics: `python -m benchmarks.many_topics TOPICS HZ`, until its input ends.

Each topic sends a sensor_msgs/Imu at a different time of the period, as sensors do.
"""

from __future__ import annotations

import asyncio
import sys

from rostether.joining import join
from rostether.rostime import Time

TYPE = "sensor_msgs/Imu"


async def main(count: int, rate_hz: float) -> None:
    """Publish until the input ends."""
    loop = asyncio.get_running_loop()
    ended = asyncio.Event()
    loop.add_reader(sys.stdin, ended.set)
    async with join("many_topics") as graph:
        publishers = [await graph.publisher(f"/imu_{number}", TYPE) for number in range(count)]
        stamp = Time.from_ns(1_700_000_000_123_456_789)
        fields = {"header": {"stamp": stamp, "frame_id": "imu_link"}, "linear_acceleration": {"z": 9.81}}
        payload = publishers[0].codec.encode(fields)
        print("ready", flush=True)
        began_s, sent = loop.time(), 0
        while not ended.is_set():
            due = int((loop.time() - began_s) * rate_hz * count)
            for number in range(sent, due):
                publishers[number % count].raw.publish_raw([payload])
            sent = due
            await asyncio.sleep(0.001)


if __name__ == "__main__":
    asyncio.run(main(int(sys.argv[1]), float(sys.argv[2])))
