"""The node sensing_manager: registers sensors, watches their topics and publishes the list of them.

sensors_register        (sensors/RegistrationService)      the reference's sensor nodes call it unchanged
sensors_register_by_id  (sensing_platform/RegisterSensor)
sensors_rename          (sensing_platform/RenameSensor)
sensors                 (sensing_platform/Sensors, latched)
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

from rostether.errors import ServiceCallError
from rostether.graph.ports import Level, Report, Snapshot, Subscriber
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.mechanisms.block_end import closed_at_end, task_beside
from rostether.mechanisms.tasks import occurs_within
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.platform.sensor_files import read_state, write_state
from rostether.platform.sensor_registration import Registration, fields_of
from rostether.platform.sensor_registry import Origin, Sensor, SensorRegistry
from rostether.rostime import Time
from rostether.serde.values import Message

# The interval between checks of the states; fast enough for a display.
STATE_PERIOD_S = 0.5
# When a fleet starts, many sensors register at once: registrations within this time cause one publication.
GATHER_S = 0.05


class SensingManager:
    """The node sensing_manager; `run` serves until canceled.

    Without `state_path`, the sensors are only in memory. `named` are the sensors of the user's file.
    """

    def __init__(
        self,
        graph: TypedGraph,
        report: Report,
        *,
        state_path: Path | None = None,
        named: Sequence[Sensor] = (),
    ) -> None:
        self._graph = graph
        self._report = report
        self._state_path = state_path
        self._named = named
        self._registry = SensorRegistry()
        self._subscribers: dict[str, Subscriber] = {}
        self._publisher: TypedPublisher[...] | None = None
        self._snapshot = Snapshot()
        self._has_changes = asyncio.Event()
        self._is_reported = False
        self._is_unsaved = False

    async def run(self) -> None:
        """Serve until canceled. Raises GraphError."""
        now_s = time.monotonic()
        restored = read_state(self._state_path) if self._state_path is not None else []
        self._registry = SensorRegistry(restored, now_s)
        for sensor in self._named:
            self._registry.add(sensor, now_s)
        if restored:
            self._report(Level.INFO, f"sensors known from an earlier run: {len(restored)}")
        graph, offer = self._graph, self._graph.service_server
        self._publisher = await graph.publisher("sensors", "sensing_platform/Sensors", latch=True)
        # This comes before the first registration, so that no sensor gets a topic in use.
        self._record_publishers(await graph.snapshot())
        async with (
            closed_at_end(self._publisher),
            closed_at_end(await offer("sensors_register", "sensors/RegistrationService", self._register)),
            closed_at_end(
                await offer("sensors_register_by_id", "sensing_platform/RegisterSensor", self._register_by_id)
            ),
            closed_at_end(await offer("sensors_rename", "sensing_platform/RenameSensor", self._rename)),
            task_beside(self._follow_connections()) as following,
        ):
            try:
                while True:
                    await self._subscribe_to_new()
                    self._registry.update_states(time.monotonic())
                    self._publish()
                    await self._save()
                    await self._wait(following)
            finally:
                await self._save()
                for subscriber in self._subscribers.values():
                    await subscriber.close()

    async def _wait(self, following: asyncio.Task[object]) -> None:
        while True:
            if following.done():
                following.result()
            if await occurs_within(self._has_changes, STATE_PERIOD_S):
                await asyncio.sleep(GATHER_S)
                self._has_changes.clear()
                return
            if self._registry.update_states(time.monotonic()):
                return

    async def _follow_connections(self) -> None:
        async for snapshot in self._graph.changes():
            self._record_publishers(snapshot)
            if self._registry.update_states(time.monotonic()):
                self._has_changes.set()

    def _record_publishers(self, snapshot: Snapshot) -> None:
        now_s = time.monotonic()
        self._adopt(snapshot, now_s)
        self._snapshot = snapshot
        for sensor in self._registry.sensors:
            self._record_publisher(sensor, now_s)

    def _record_publisher(self, sensor: Sensor, now_s: float) -> None:
        topic = self._snapshot.topics.get(self._graph.resolve(sensor.topic))
        self._registry.record_connection(sensor.id, topic is not None and bool(topic.publishers), now_s)
        if topic is not None:
            self._registry.record_type(sensor.id, _ros1_type(topic.type))

    def _adopt(self, snapshot: Snapshot, now_s: float) -> None:
        """Add the sensors that publish on topics of this manager, but are not in its saved state."""
        prefix = self._graph.resolve("sensor_node")
        for name, entry in snapshot.topics.items():
            if name.startswith(prefix) and entry.publishers:
                platform = entry.publishers[0].lstrip("/") or "Platform"
                # The list may be full.
                with suppress(ServiceCallError):
                    self._is_unsaved |= self._registry.adopt(
                        f"sensor_node{name.removeprefix(prefix)}", _ros1_type(entry.type), platform, now_s
                    )

    async def _subscribe_to_new(self) -> None:
        """Subscribe to the sensors without a lease, except cameras: pictures cost too much."""
        for sensor in self._registry.sensors:
            if sensor.origin is Origin.ID or sensor.is_camera:
                continue
            if sensor.id not in self._subscribers:
                self._subscribers[sensor.id] = await self._graph.raw.subscribe(
                    sensor.topic, ANY_MESSAGE, partial(self._handle_messages, sensor.id)
                )
        for sensor_id in self._subscribers.keys() - {each.id for each in self._registry.sensors}:
            await self._subscribers.pop(sensor_id).close()

    def _handle_messages(self, sensor_id: str, _: Sequence[bytes]) -> None:
        now_s = time.monotonic()
        self._registry.record_message(sensor_id, now_s)
        if not self._registry.is_ready(sensor_id) and self._registry.update_states(now_s):
            self._has_changes.set()

    def _register(self, request: Message) -> dict[str, str]:
        sensor = self._registry.register(request.platform_name, request.sensor_type, time.monotonic())
        self._report(Level.INFO, f"registered {sensor.platform} {sensor.sensor_type} on topic {sensor.topic}")
        self._mark_changed()
        return {"topic": sensor.topic}

    def _register_by_id(self, request: Message) -> dict[str, str]:
        wanted = Registration(
            id=request.id,
            instance=request.instance,
            name=request.name,
            platform=request.platform_name,
            **fields_of(request),
            state=request.state or "ready",
            state_text=request.state_text,
        )
        now_s = time.monotonic()
        before = self._registry.find(wanted.id)
        sensor, refusal = self._registry.register_by_id(wanted, now_s)
        topic = self._graph.resolve(sensor.topic)
        if before is None:
            # A sensor that was registered with an earlier manager already publishes.
            self._record_publisher(sensor, now_s)
            self._report(Level.INFO, f"registered {sensor.id} on topic {topic}")
        if sensor != before:
            self._mark_changed()
        elif self._registry.update_states(now_s):
            self._has_changes.set()
        return {"topic": topic, "name": sensor.name, "refusal": refusal}

    def _rename(self, request: Message) -> dict[str, object]:
        sensor = self._registry.rename(request.id, request.name)
        self._report(Level.INFO, f"sensor {sensor.id} now has the name {sensor.name!r}")
        self._mark_changed()
        return {"sensor": self._shown(sensor)}

    def _mark_changed(self) -> None:
        self._is_unsaved = True
        self._has_changes.set()

    async def _save(self) -> None:
        if self._state_path is None or not self._is_unsaved:
            return
        self._is_unsaved = False
        kept = [each for each in self._registry.sensors if each.origin is not Origin.FILE]
        try:
            # Runs in a thread, because the memory card of a small computer can be slow.
            await asyncio.to_thread(write_state, self._state_path, kept)
        except OSError as error:
            if not self._is_reported:
                self._is_reported = True
                self._report(
                    Level.ERROR,
                    f"cannot write {self._state_path}: {error.strerror or error}; make it writable, or the "
                    "sensors are lost at a restart",
                )

    def _publish(self) -> None:
        assert self._publisher is not None
        self._publisher.publish(sensors=[self._shown(each) for each in self._registry.sensors])

    def _shown(self, sensor: Sensor) -> dict[str, object]:
        state, state_text, since_s = self._registry.state(sensor.id)
        age_ns = int(max(0.0, time.monotonic() - since_s) * 1e9)
        return {
            "id": sensor.id,
            "name": sensor.name,
            "platform_name": sensor.platform,
            "topic": self._graph.resolve(sensor.topic),
            **fields_of(sensor),
            "state": state,
            "state_text": state_text,
            "state_since": Time.from_ns(max(0, self._graph.now().to_ns() - age_ns)),
        }


def _ros1_type(name: str) -> str:
    """Return a type's name as in ROS 1: snapshots of ROS 2 have `std_msgs/msg/Float64`."""
    return name.replace("/msg/", "/")
