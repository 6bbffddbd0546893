"""The node camera: pictures as a sensor, published and taken only while a program receives them."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing

from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph
from rostether.platform.sensors.picture_sources import PictureSource
from rostether.platform.sensors.readings import publish_readings
from rostether.platform.sensors.registered_sensor import (
    RegisteredSensor,
    SensorDescription,
    registered_sensor,
)

MESSAGE_TYPE = "sensor_msgs/CompressedImage"

_HINT = "plug the camera in, or choose another ~source, such as test"

# The longest delay before the first picture for a new subscriber.
_POLL_S = 0.1
# A slow subscriber gets fewer pictures.
_DRAIN_LIMIT_S = 5.0


async def publish_pictures(
    graph: TypedGraph,
    description: SensorDescription,
    source: PictureSource,
    report: Callable[[Level, str], None],
) -> None:
    """Publish the pictures of a source as a sensor until cancelled. Raises GraphError."""
    count = 0
    async with registered_sensor(graph, description, report) as sensor:

        def publish(picture: bytes | None) -> None:
            nonlocal count
            sensor.set_state("ready")
            if picture is None:
                return
            header = {"seq": count, "stamp": graph.now(), "frame_id": description.frame_id}
            sensor.publish(header=header, format="jpeg", data=picture)
            count += 1

        await publish_readings(sensor, lambda: _while_wanted(sensor, source), publish, report, hint=_HINT)


async def _while_wanted(
    sensor: RegisteredSensor, source: PictureSource
) -> AsyncGenerator[bytes | None, None]:
    """Yield pictures while a program receives them, and None every second while none does."""
    loop = asyncio.get_running_loop()
    while True:
        looked_s = float("-inf")
        while not sensor.is_wanted:
            if loop.time() >= looked_s + 1.0:
                looked_s = loop.time()
                await asyncio.to_thread(source.check)
                yield None
            await asyncio.sleep(_POLL_S)
        async with aclosing(source.pictures(sensor.description.rate_hz)) as pictures:
            async for picture in pictures:
                yield picture
                await sensor.publisher.drained(_DRAIN_LIMIT_S)
                if not sensor.is_wanted:
                    break
