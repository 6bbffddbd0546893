"""The nodes analog and digital: one number as a sensor, from a system file, a GPIO line or a topic."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing

from msgspec import Struct

from rostether.errors import ConfigError, SensorError
from rostether.graph.ports import Report
from rostether.graph.typed_graph import TypedGraph
from rostether.platform.sensor_registration import SensorDescription
from rostether.platform.sensors.readings import publish_readings
from rostether.platform.sensors.registered_sensor import registered_sensor
from rostether.serde.field_path import FieldPath

MESSAGE_TYPE = "std_msgs/Float64"

# How long an alert lasts at least: a value near its limit would change the state with each reading.
_ALERT_HOLD_S = 2.0


class Scaling(Struct, frozen=True):
    """Scales a number: `value * scale + offset`; outside the limits the sensor is in alert."""

    scale: float = 1.0
    offset: float = 0.0
    alert_below: float = float("-inf")
    alert_above: float = float("inf")

    def alert(self, value: float, unit: str) -> str:
        """Return why a value causes an alert, or an empty string."""
        if math.isnan(value):
            return "not a number"
        unit = f" {unit}" if unit else ""
        if value < self.alert_below:
            return f"below {self.alert_below:g}{unit}"
        return f"above {self.alert_above:g}{unit}" if value > self.alert_above else ""


async def publish_values(
    graph: TypedGraph,
    description: SensorDescription,
    open_source: Callable[[], AsyncGenerator[float, None]],
    scaling: Scaling,
    report: Report,
    *,
    hint: str = "choose another ~path, ~gpio or ~field",
    silence: str = "",
) -> None:
    """Publish the numbers of a source as a sensor until canceled. Raises GraphError, ConfigError.

    `hint` and `silence` are the texts for users if the source fails, and while it sends no number.
    """
    async with registered_sensor(graph, description, report) as sensor:
        loop = asyncio.get_running_loop()
        alert_until_s = 0.0

        def publish(reading: float) -> None:
            nonlocal alert_until_s
            value = reading * scaling.scale + scaling.offset
            sensor.publish(data=value)
            if reason := scaling.alert(value, description.unit):
                alert_until_s = loop.time() + _ALERT_HOLD_S
                sensor.set_state("alert", reason)
            elif loop.time() >= alert_until_s:
                sensor.set_state("ready")

        await publish_readings(sensor, open_source, publish, hint=hint, silence=silence)


class TopicField:
    """A field of a topic, such as `range` or `pose/position/x`, as a source of numbers."""

    def __init__(self, graph: TypedGraph, topic: str, field: str) -> None:
        self._graph = graph
        self._topic = topic
        self._field = field
        self._has_number = False

    @property
    def silence(self) -> str:
        """The reason to show if no message arrives: often, the name of the topic is wrong."""
        return f"no message on {self._graph.resolve(self._topic)}; check its name: rostether topic list"

    async def values(self) -> AsyncGenerator[float, None]:
        """Yield the field of each message; true is 1.

        Raises ConfigError if the first message has no such number, SensorError if a later one has none: a
        board may get another sketch. Raises GraphError.
        """
        async with aclosing(aiter(self._graph.messages(self._topic))) as messages:
            path: FieldPath | None = None
            type_name = ""
            async for message in messages:
                try:
                    if path is None or message._type != type_name:
                        type_name = message._type
                        path = FieldPath(self._graph.store.codec(type_name), self._field)
                    value = path.read(message)
                    if not isinstance(value, int | float):
                        raise ConfigError(f"{self._topic}: {self._field} of {type_name} is not a number")
                except ConfigError as error:
                    if not self._has_number:
                        raise
                    raise SensorError(str(error)) from None
                self._has_number = True
                yield float(value)
