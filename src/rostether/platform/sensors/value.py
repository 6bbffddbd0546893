"""The nodes analog and digital: one number as a sensor, from a file of the system, a GPIO line or a topic."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Callable
from dataclasses import dataclass

from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph
from rostether.platform.sensors.readings import publish_readings
from rostether.platform.sensors.registered_sensor import SensorDescription, registered_sensor

MESSAGE_TYPE = "std_msgs/Float64"


@dataclass(frozen=True, slots=True)
class Scaling:
    """What becomes of a number: `value * scale + offset`; outside the limits the sensor is in alert."""

    scale: float = 1.0
    offset: float = 0.0
    alert_below: float = float("-inf")
    alert_above: float = float("inf")

    def alert(self, value: float, unit: str) -> str:
        """Return why a value is an alert, "" if it is none."""
        unit = f" {unit}" if unit else ""
        if value < self.alert_below:
            return f"below {self.alert_below:g}{unit}"
        return f"above {self.alert_above:g}{unit}" if value > self.alert_above else ""


async def publish_values(
    graph: TypedGraph,
    description: SensorDescription,
    open_source: Callable[[], AsyncGenerator[float, None]],
    scaling: Scaling,
    report: Callable[[Level, str], None],
) -> None:
    """Publish the numbers of a source as a sensor until cancelled. Raises GraphError."""
    async with registered_sensor(graph, description, report) as sensor:

        def publish(reading: float) -> None:
            value = reading * scaling.scale + scaling.offset
            sensor.publish(data=value)
            reason = scaling.alert(value, description.unit)
            sensor.set_state("alert" if reason else "ready", reason)

        await publish_readings(sensor, open_source, publish, report)
