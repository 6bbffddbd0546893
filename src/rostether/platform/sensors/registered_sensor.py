"""A sensor that a node publishes: registered by its id, with a lease that the node renews.

It publishes immediately, with or without a sensing manager, and registers again when the manager restarts.
"""

from __future__ import annotations

import asyncio
import re
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from msgspec.structs import asdict

from rostether.errors import GraphError
from rostether.graph.ports import Level, Report
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.block_end import closed_at_end, task_beside
from rostether.mechanisms.tasks import occurs_within
from rostether.platform.sensor_registration import SensorDescription
from rostether.platform.sensor_state import MAX_STATE_TEXT_CHARACTERS

# A manager that restarts without its file knows all sensors again after a renewal period.
LEASE_S = 12.0
RENEWAL_S = LEASE_S / 3
# The first delay after a failed registration; later delays grow to the renewal period.
RETRY_S = 0.5
# Limits the load of the manager if a state changes all the time.
_SHORTEST_PERIOD_S = 0.2
# Less than half of the lease: if a call gets no answer, another one can still renew it.
_CALL_LIMIT_S = 5.0


def platform_word(platform: str) -> str:
    """Return a platform's name for use in a sensor's id: letters, digits and underscores."""
    word = re.sub(r"[^A-Za-z0-9_]", "_", platform)
    return word if word[:1].isalpha() else f"p{word}"


class RegisteredSensor:
    """Publishes a sensor's messages and reports its state; made by `registered_sensor`."""

    def __init__(
        self,
        graph: TypedGraph,
        description: SensorDescription,
        publisher: TypedPublisher[...],
        report: Report,
    ) -> None:
        self.description = description
        self.publisher = publisher
        self._graph = graph
        self.report = report
        self._state = "init"
        self._state_text = ""
        self._has_changed = asyncio.Event()
        self._is_refused = False
        self._reported = ""

    @property
    def is_wanted(self) -> bool:
        """Whether a program receives the messages."""
        return self.publisher.subscriber_count > 0 and not self._is_refused

    def header(self) -> dict[str, object]:
        """Return the header of a message that is made now."""
        return {"stamp": self._graph.now(), "frame_id": self.description.frame_id}

    def publish(self, **fields: Any) -> bool:
        """Publish a message, unless another node publishes this sensor.

        If it returns False, await `publisher.drained` before the next message.
        """
        return self._is_refused or self.publisher.publish(**fields)

    def set_state(self, state: str, text: str = "") -> None:
        """Report a state from `sensor_state.REPORTED` to the manager, with its reason."""
        printable = "".join(each if each.isprintable() else " " for each in text)[:MAX_STATE_TEXT_CHARACTERS]
        if (state, printable) != (self._state, self._state_text):
            self._state, self._state_text = state, printable
            self._has_changed.set()

    async def keep_registered(self) -> None:
        """Register, and renew the lease, until canceled."""
        backoff = Backoff(first_s=RETRY_S, limit_s=RENEWAL_S)
        while True:
            self._has_changed.clear()
            if not await self._register():
                await asyncio.sleep(backoff.next_delay_s())
                continue
            backoff.reset()
            await asyncio.sleep(_SHORTEST_PERIOD_S)
            await occurs_within(self._has_changed, RENEWAL_S)

    async def _register(self) -> bool:
        what = self.description
        fields = asdict(what)
        request = {
            "platform_name": fields.pop("platform"),
            **fields,
            "instance": f"{self._graph.node_name} on {socket.gethostname()}",
            "lease_s": LEASE_S,
            "state": self._state,
            "state_text": self._state_text,
        }
        try:
            answer = await self._graph.call(
                "/sensors_register_by_id", "sensing_platform/RegisterSensor", request, timeout_s=_CALL_LIMIT_S
            )
        except GraphError as error:
            self._report_once(Level.WARN, f"not registered as {what.id} yet: {error}")
            return False
        self._is_refused = bool(answer.refusal)
        if self._is_refused:
            # Without the remaining time of the lease, which differs in each refusal.
            self._report_once(
                Level.ERROR, f"not publishing: {answer.refusal.partition(' for ')[0]}; choose another ~id"
            )
            return False
        self._report_once(Level.INFO, f"registered as {what.id}, on topic {self.publisher.topic}")
        return True

    def _report_once(self, level: Level, text: str) -> None:
        if text != self._reported:
            self._reported = text
            self.report(level, text)


@asynccontextmanager
async def registered_sensor(
    graph: TypedGraph, description: SensorDescription, report: Report
) -> AsyncIterator[RegisteredSensor]:
    """Publish and keep the sensor registered within the block. Raises GraphError."""
    opened = await graph.publisher(description.topic, description.message_type)
    async with closed_at_end(opened) as publisher:
        sensor = RegisteredSensor(graph, description, publisher, report)
        async with task_beside(sensor.keep_registered()):
            yield sensor
