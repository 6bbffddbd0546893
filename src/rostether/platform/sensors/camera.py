"""The node camera: pictures as a sensor, taken and published only while a program receives them."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator
from contextlib import aclosing

from msgspec.structs import asdict

from rostether.graph.ports import Report
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.mechanisms.block_end import closed_at_end
from rostether.platform.sensor_registration import SensorDescription
from rostether.platform.sensors.cascade import CascadeDetector, Region
from rostether.platform.sensors.picture_sources import PictureSource
from rostether.platform.sensors.readings import publish_readings
from rostether.platform.sensors.registered_sensor import RegisteredSensor, registered_sensor

MESSAGE_TYPE = "sensor_msgs/CompressedImage"
_DETECTIONS_TYPE = "sensing_platform/Detections"

_HINT = "plug the camera in, or choose another ~source, such as test"

# The longest delay before the first picture for a new subscriber; users do not notice it.
_POLL_S = 0.1
# The longest wait for a slow subscriber between two pictures: others must get pictures if one hangs.
_DRAIN_LIMIT_S = 5.0


async def publish_pictures(
    graph: TypedGraph,
    description: SensorDescription,
    source: PictureSource,
    report: Report,
    detector: CascadeDetector | None = None,
) -> None:
    """Publish the pictures of a source as a sensor until canceled. Raises GraphError.

    With a detector, boxes are drawn around the detected objects, and published on `<topic>/detections`.
    """
    async with registered_sensor(graph, description, report) as sensor:
        if detector is None:
            await _Camera(sensor, source, None, None).run()
            return
        detections = await graph.publisher(f"{description.topic}/detections", _DETECTIONS_TYPE)
        async with closed_at_end(detections):
            await _Camera(sensor, source, detector, detections).run()


class _Camera:
    def __init__(
        self,
        sensor: RegisteredSensor,
        source: PictureSource,
        detector: CascadeDetector | None,
        detections: TypedPublisher[...] | None,
    ) -> None:
        self._sensor = sensor
        self._source = source
        self._detector = detector
        self._detections = detections
        self._count = 0

    async def run(self) -> None:
        """Publish until canceled."""
        await publish_readings(self._sensor, self._while_wanted, self._publish, hint=_HINT)

    def _publish(self, reading: tuple[list[Region], bytes] | None) -> None:
        self._sensor.set_state("ready")
        if reading is None:
            return
        regions, picture = reading
        header = {"seq": self._count, **self._sensor.header()}
        self._count += 1
        self._sensor.publish(header=header, format="jpeg", data=picture)
        if self._detections is not None and self._detector is not None:
            boxes = [asdict(each) for each in regions]
            self._detections.publish(header=header, classifier=self._detector.name, regions=boxes)

    async def _while_wanted(self) -> AsyncGenerator[tuple[list[Region], bytes] | None, None]:
        """Yield pictures while a program receives them, and None every second while none does."""
        loop = asyncio.get_running_loop()
        while True:
            checked_s = float("-inf")
            while not self._is_wanted():
                if loop.time() >= checked_s + 1.0:
                    checked_s = loop.time()
                    await asyncio.to_thread(self._source.check)
                    yield None
                await asyncio.sleep(_POLL_S)
            async with aclosing(self._source.pictures(self._sensor.description.rate_hz)) as pictures:
                async for picture in pictures:
                    if self._detector is None:
                        yield [], picture
                    else:
                        yield await asyncio.to_thread(self._detector.detect, picture)
                    await self._sensor.publisher.drained(_DRAIN_LIMIT_S)
                    if not self._is_wanted():
                        break

    def _is_wanted(self) -> bool:
        has_viewer = self._detections is not None and self._detections.subscriber_count > 0
        return self._sensor.is_wanted or has_viewer
