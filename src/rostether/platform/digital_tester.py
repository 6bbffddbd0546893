"""The node digital_tester: a sensor without hardware, to test a system from the sensor to the screen."""

from __future__ import annotations

import asyncio
import random

from rostether.errors import ServiceCallError, ServiceTimeoutError, ServiceUnavailableError
from rostether.graph.ports import Level, Report
from rostether.graph.typed_graph import TypedGraph

# The interval between values: slow enough to follow on a screen.
PERIOD_S = 1.0
# The interval between attempts to register; a manager is started by hand.
_RETRY_S = 1.0
# A manager that is only slow has answered by then.
_CALL_LIMIT_S = 10.0


async def publish_test_values(graph: TypedGraph, platform: str, report: Report) -> None:
    """Register a DIGITAL sensor and publish a whole number from 0 to 100 each second, until canceled.

    It waits for the sensing manager. Raises ServiceCallError if the manager refuses, GraphError.
    """
    topic = await _register(graph, platform, report)
    report(Level.INFO, f"registered for topic {topic}")
    publisher = await graph.publisher(topic, "std_msgs/Float64")
    while True:
        publisher.publish(data=float(random.randint(0, 100)))  # noqa: S311
        await asyncio.sleep(PERIOD_S)


async def _register(graph: TypedGraph, platform: str, report: Report) -> str:
    request = {"platform_name": platform, "sensor_type": "DIGITAL"}
    is_reported = False
    while True:
        try:
            answer = await graph.call(
                "sensors_register", "sensors/RegistrationService", request, timeout_s=_CALL_LIMIT_S
            )
        except (ServiceUnavailableError, ServiceTimeoutError):
            if not is_reported:
                is_reported = True
                report(Level.WARN, "no sensing manager answers; start one: rostether role sensing-manager")
            await asyncio.sleep(_RETRY_S)
        except ServiceCallError as error:
            raise ServiceCallError(f"the sensing manager refuses this sensor: {error}") from None
        else:
            return str(answer.topic)
