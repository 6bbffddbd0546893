"""The sensors of all platforms and their states; without clock, graph or files.

A sensor's id and topic never change; its name may. The states follow from its topic:

    init          registered, has not published yet
    ready         publishes, or a camera that waits for a subscriber
    sleeping      connected, but silent for `SILENT_S`
    disconnected  its publisher has gone
    lost          not connected for `LOST_S`
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from rostether.errors import ServiceCallError

# By the sensor types of the registration service.
MESSAGE_TYPES = {
    "CAMERA": "sensor_msgs/CompressedImage",
    "ANALOG": "std_msgs/Float64",
    "DIGITAL": "std_msgs/Float64",
}

# Each costs a subscription; the longest lost one is replaced.
MAX_SENSORS = 1000

MAX_TEXT_CHARACTERS = 100
SILENT_S = 3.0
LOST_S = 60.0


@dataclass(frozen=True, slots=True)
class Sensor:
    """The identity and description of a sensor. `number` is -1 if it comes from the sensors' file."""

    id: str
    number: int
    platform: str
    sensor_type: str
    topic: str
    name: str
    message_type: str = ""
    unit: str = ""


@dataclass(slots=True)
class _Condition:
    """The observations of a sensor's topic; times are seconds of a monotonic clock."""

    since_s: float
    state: str = "init"
    is_connected: bool = False
    was_connected: bool = False
    left_s: float = 0.0
    heard_s: float | None = None


class SensorRegistry:
    """All sensors in the order of their registration."""

    def __init__(self, sensors: Iterable[Sensor] = (), now_s: float = 0.0) -> None:
        self._sensors: dict[str, Sensor] = {each.id: each for each in sensors}
        # They have published in an earlier run, so that a returning sensor gets its old entry.
        self._conditions = {
            key: _Condition(now_s, "disconnected", was_connected=True, left_s=now_s) for key in self._sensors
        }
        self._next_number = 1 + max((each.number for each in self._sensors.values()), default=-1)

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """All sensors."""
        return tuple(self._sensors.values())

    def state(self, sensor_id: str) -> tuple[str, float]:
        """Return a sensor's state, and its start time."""
        condition = self._conditions[sensor_id]
        return condition.state, condition.since_s

    def is_ready(self, sensor_id: str) -> bool:
        """Return whether a sensor is known and ready."""
        return sensor_id in self._conditions and self._conditions[sensor_id].state == "ready"

    def register(self, platform: str, sensor_type: str, now_s: float) -> Sensor:
        """Return the sensor of a platform that registers one: a new one, or one of its type that has gone.

        Raises ServiceCallError for a type or a name that cannot be used.
        """
        _check_text("platform_name", platform)
        if sensor_type not in MESSAGE_TYPES:
            raise ServiceCallError(f"sensor_type is {', '.join(MESSAGE_TYPES)}, not {sensor_type!r:.100}")
        found = self._find_gone(platform, sensor_type)
        if found is None:
            number = self._next_number
            topic = f"sensor_node{number}"
            name = f"{platform} {sensor_type} {number}"
            found = Sensor(topic, number, platform, sensor_type, topic, name, MESSAGE_TYPES[sensor_type])
            self.add(found, now_s)
            self._next_number += 1
        else:
            self._conditions[found.id] = _Condition(now_s, left_s=now_s)
        return found

    def add(self, sensor: Sensor, now_s: float) -> None:
        """Add a sensor. Raises ServiceCallError when there are too many."""
        self._make_place()
        self._conditions[sensor.id] = _Condition(now_s, left_s=now_s)
        self._sensors[sensor.id] = sensor

    def rename(self, sensor_id: str, name: str) -> Sensor:
        """Rename a sensor; id, topic and state do not change. Raises ServiceCallError."""
        _check_text("name", name)
        if sensor_id not in self._sensors:
            raise ServiceCallError(f"no sensor has the id {sensor_id!r:.100}; see: rostether sensor list")
        if self._sensors[sensor_id].number < 0:
            raise ServiceCallError(f"the name of {sensor_id} is in the sensors' file: change it there")
        self._sensors[sensor_id] = replace(self._sensors[sensor_id], name=name)
        return self._sensors[sensor_id]

    def connect(self, sensor_id: str, is_connected: bool, now_s: float) -> None:
        """Record whether the sensor's topic has a publisher now."""
        condition = self._conditions[sensor_id]
        if condition.is_connected and not is_connected:
            condition.left_s = now_s
        if is_connected and not condition.is_connected:
            condition.heard_s = None
        condition.is_connected = is_connected
        condition.was_connected |= is_connected

    def note_message(self, sensor_id: str, now_s: float) -> None:
        """Record a message of the sensor; ignores unknown sensors."""
        if (condition := self._conditions.get(sensor_id)) is not None:
            condition.is_connected = condition.was_connected = True
            condition.heard_s = now_s

    def judge(self, now_s: float) -> bool:
        """Set all states by age; True if any has changed."""
        has_changed = False
        for key, condition in self._conditions.items():
            state = _state(condition, self._sensors[key], now_s)
            if state != condition.state:
                condition.state, condition.since_s = state, now_s
                has_changed = True
        return has_changed

    def _find_gone(self, platform: str, sensor_type: str) -> Sensor | None:
        for sensor in self._sensors.values():
            if (sensor.platform, sensor.sensor_type) == (platform, sensor_type) and sensor.number >= 0:
                condition = self._conditions[sensor.id]
                # A new sensor may be about to publish: it has just been registered.
                if condition.was_connected and not condition.is_connected:
                    return sensor
        return None

    def _make_place(self) -> None:
        if len(self._sensors) < MAX_SENSORS:
            return
        lost = [key for key, each in self._conditions.items() if each.state == "lost"]
        if not lost:
            raise ServiceCallError(f"there are {MAX_SENSORS} sensors already, and none of them is lost")
        oldest = min(lost, key=lambda key: self._conditions[key].since_s)
        del self._sensors[oldest], self._conditions[oldest]


def _state(condition: _Condition, sensor: Sensor, now_s: float) -> str:
    if not condition.is_connected:
        if now_s - condition.left_s >= LOST_S:
            return "lost"
        return "disconnected" if condition.was_connected else "init"
    # A camera publishes only while it has subscribers; the manager does not subscribe to pictures.
    if sensor.sensor_type == "CAMERA":
        return "ready"
    if condition.heard_s is None:
        return "init" if condition.state in ("init", "disconnected", "lost") else "sleeping"
    return "sleeping" if now_s - condition.heard_s >= SILENT_S else "ready"


def _check_text(what: str, text: str) -> None:
    if not text.strip() or len(text) > MAX_TEXT_CHARACTERS or not text.isprintable():
        raise ServiceCallError(
            f"{what} is 1 to {MAX_TEXT_CHARACTERS} printable characters, not {text!r:.100}"
        )
