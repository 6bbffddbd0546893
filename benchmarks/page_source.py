"""The topics of a robot for the page: `python -m benchmarks.page_source`, until its input ends.

20 ranges at 50 Hz, a camera of 30 kB a picture at 15 Hz, six transforms at 30 Hz: 1,045 messages a second.
"""

from __future__ import annotations

import asyncio
import io
import math
import sys
import time
from collections.abc import Callable
from random import Random

from PIL import Image

from rostether.graph.typed_graph import TypedGraph
from rostether.joining import join
from rostether.rostime import Time

RANGES, RANGE_HZ = 20, 50.0
PICTURE_BYTES, PICTURE_HZ = 30_000, 15.0
FRAMES, FRAMES_HZ = 6, 30.0


async def main() -> None:
    """Publish until the input ends."""
    ended = asyncio.Event()
    asyncio.get_running_loop().add_reader(sys.stdin, ended.set)
    async with join("page_source") as graph:
        tasks = [
            asyncio.create_task(_each(hertz, send))
            for hertz, send in (*await _ranges(graph), await _camera(graph), await _frames(graph))
        ]
        print("ready", flush=True)
        await ended.wait()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _each(hertz: float, send: Callable[[float], None]) -> None:
    loop = asyncio.get_running_loop()
    began_s = loop.time()
    count = 0
    while True:
        count += 1
        await asyncio.sleep(began_s + count / hertz - loop.time())
        send(count / hertz)


async def _ranges(graph: TypedGraph) -> list[tuple[float, Callable[[float], None]]]:
    found: list[tuple[float, Callable[[float], None]]] = []
    for number in range(RANGES):
        publisher = await graph.publisher(f"/range_{number}", "sensor_msgs/Range")

        def send(
            time_s: float, number: int = number, publish: Callable[..., object] = publisher.publish
        ) -> None:
            publish({"header": _header(), "max_range": 4.0, "range": 2 + math.sin(time_s + number)})

        found.append((RANGE_HZ, send))
    return found


async def _camera(graph: TypedGraph) -> tuple[float, Callable[[float], None]]:
    publisher = await graph.publisher("/camera/compressed", "sensor_msgs/CompressedImage")
    noise = Image.frombytes("RGB", (160, 120), Random(1).randbytes(160 * 120 * 3)).resize((640, 480))
    data = b""
    for quality in range(5, 95, 5):
        file = io.BytesIO()
        noise.save(file, "JPEG", quality=quality)
        data = file.getvalue()
        if len(data) >= PICTURE_BYTES:
            break

    def send(_: float) -> None:
        publisher.publish({"header": _header(), "format": "jpeg", "data": data})

    return PICTURE_HZ, send


async def _frames(graph: TypedGraph) -> tuple[float, Callable[[float], None]]:
    publisher = await graph.publisher("/tf", "tf2_msgs/TFMessage")

    def send(time_s: float) -> None:
        transforms = [
            {
                "header": _header(f"link_{number}" if number else "base"),
                "child_frame_id": f"link_{number + 1}",
                "transform": {
                    "translation": {"x": 0.3, "y": 0.0, "z": 0.1},
                    "rotation": {"z": math.sin(time_s / 2), "w": math.cos(time_s / 2)},
                },
            }
            for number in range(FRAMES)
        ]
        publisher.publish({"transforms": transforms})

    return FRAMES_HZ, send


def _header(frame: str = "base") -> dict[str, object]:
    return {"stamp": Time.from_ns(time.time_ns()), "frame_id": frame}


if __name__ == "__main__":
    asyncio.run(main())
