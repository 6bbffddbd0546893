"""The sensors of all platforms; without clock, graph or files.

A sensor's id and topic never change; its name may.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from enum import Enum

from msgspec import Struct
from msgspec.structs import replace

from rostether.errors import ServiceCallError
from rostether.mechanisms.text import escape_line
from rostether.platform.sensor_registration import MAX_TEXT_CHARACTERS, Registration, check_text, fields_of
from rostether.platform.sensor_state import Condition

# The message type for each sensor type of the registration service.
MESSAGE_TYPES = {
    "CAMERA": "sensor_msgs/CompressedImage",
    "ANALOG": "std_msgs/Float64",
    "DIGITAL": "std_msgs/Float64",
}

# Each sensor costs a subscription. A new sensor replaces the sensor that has been lost for the longest time.
MAX_SENSORS = 1000

_COUNTED_TOPIC = re.compile(r"sensor_node(0|[1-9][0-9]{0,8})")


class Origin(Enum):
    """How a sensor became known to the manager."""

    # The reference's service: the topic is `sensor_node` and a number.
    COUNTED = "counted"
    # The service with an id: the topic is `/sensors/` and the id.
    ID = "id"
    # An entry in sensors.toml: the topic is a board's.
    FILE = "file"


class Sensor(Struct, frozen=True):
    """The identity and description of a sensor.

    `number` is the one in the name of a numbered topic, else -1. `registered_name` is the name in the last
    registration.
    """

    id: str
    number: int
    platform: str
    sensor_type: str
    topic: str
    name: str
    message_type: str = ""
    unit: str = ""
    frame_id: str = ""
    rate_hz: float = 0.0
    lease_s: float = 0.0
    registered_name: str = ""

    @property
    def origin(self) -> Origin:
        """How the manager learned of the sensor."""
        if self.number >= 0:
            return Origin.COUNTED
        return Origin.ID if self.lease_s else Origin.FILE

    @property
    def is_camera(self) -> bool:
        """Whether its messages are pictures."""
        return self.sensor_type == "CAMERA"


class SensorRegistry:
    """All sensors in the order of their registration."""

    def __init__(self, sensors: Iterable[Sensor] = (), now_s: float = 0.0) -> None:
        self._sensors: dict[str, Sensor] = {each.id: each for each in sensors}
        # Sensors of an earlier run: a returning sensor gets its old entry.
        self._conditions = {
            key: Condition(
                now_s,
                "disconnected",
                was_connected=True,
                left_s=now_s,
                lease_until_s=now_s + each.lease_s if each.origin is Origin.ID else None,
                reported="ready",
            )
            for key, each in self._sensors.items()
        }
        self._next_number = 1 + max((each.number for each in self._sensors.values()), default=-1)

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """All sensors."""
        return tuple(self._sensors.values())

    def find(self, sensor_id: str) -> Sensor | None:
        """Return the sensor with an id, None if there is none."""
        return self._sensors.get(sensor_id)

    def state(self, sensor_id: str) -> tuple[str, str, float]:
        """Return a sensor's state, the sensor's text about it, and the time of its last change."""
        condition = self._conditions[sensor_id]
        return condition.state, condition.text, condition.since_s

    def is_ready(self, sensor_id: str) -> bool:
        """Return whether a sensor is known and ready."""
        return sensor_id in self._conditions and self._conditions[sensor_id].state == "ready"

    def register(self, platform: str, sensor_type: str, now_s: float) -> Sensor:
        """Register a sensor of a platform: return a new one, or a disconnected one of the same type.

        Raises ServiceCallError for an invalid type or name, and when there are too many sensors.
        """
        check_text("platform_name", platform)
        if sensor_type not in MESSAGE_TYPES:
            raise ServiceCallError(
                f"sensor_type must be one of {', '.join(MESSAGE_TYPES)}, not {sensor_type!r:.100}"
            )
        found = self._find_gone(platform, sensor_type)
        if found is None:
            found = self._add_counted(self._next_number, platform, sensor_type, now_s)
        else:
            self._conditions[found.id] = Condition(now_s, left_s=now_s)
        return found

    def register_by_id(self, wanted: Registration, now_s: float) -> tuple[Sensor, str]:
        """Register a sensor or renew its lease; return it, and why it must wait, or an empty string.

        The sensor must wait while another process holds its lease. Raises ServiceCallError for an invalid
        field, for an id that another kind of sensor uses, and when there are too many sensors.
        """
        wanted.check()
        before = self._sensors.get(wanted.id)
        if before is not None and before.origin is not Origin.ID:
            raise ServiceCallError(f"the sensor {wanted.id} exists and has no lease; choose another id")
        if before is None:
            if _COUNTED_TOPIC.fullmatch(wanted.id):
                raise ServiceCallError(f"the id {wanted.id} is reserved for sensors_register; choose another")
            name = wanted.name or wanted.id
            before = Sensor(wanted.id, -1, "", "", f"/sensors/{wanted.id}", name, lease_s=wanted.lease_s)
            self.add(before, now_s)
        condition = self._conditions[wanted.id]
        if condition.instance not in ("", wanted.instance) and condition.holds_lease(now_s):
            remaining_s = (condition.lease_until_s or now_s) - now_s
            return before, f"{condition.instance} is registered as {wanted.id} for {remaining_s:.0f} s more"
        # The latest name is used, from a registration or from a user.
        has_new_name = wanted.name not in ("", before.registered_name)
        self._sensors[wanted.id] = replace(
            before,
            name=wanted.name if has_new_name else before.name,
            registered_name=wanted.name,
            platform=wanted.platform,
            **fields_of(wanted),
        )
        condition.instance = wanted.instance
        condition.lease_until_s = now_s + wanted.lease_s
        condition.reported, condition.reported_text = wanted.state, wanted.state_text
        return self._sensors[wanted.id], ""

    def adopt(self, topic: str, message_type: str, platform: str, now_s: float) -> bool:
        """Add the sensor that publishes on an unregistered numbered topic; return False for another topic.

        It was registered with an earlier manager, whose saved state is missing. Raises ServiceCallError
        when there are too many.
        """
        found = _COUNTED_TOPIC.fullmatch(topic)
        if found is None or topic in self._sensors:
            return False
        sensor_type = "CAMERA" if message_type == MESSAGE_TYPES["CAMERA"] else "ANALOG"
        platform = escape_line(platform, MAX_TEXT_CHARACTERS)
        self._add_counted(int(found[1]), platform, sensor_type, now_s)
        return True

    def add(self, sensor: Sensor, now_s: float) -> None:
        """Add a sensor. Raises ServiceCallError when there are too many."""
        self._make_room()
        self._conditions[sensor.id] = Condition(now_s, left_s=now_s)
        self._sensors[sensor.id] = sensor

    def rename(self, sensor_id: str, name: str) -> Sensor:
        """Rename a sensor; id, topic and state do not change. Raises ServiceCallError."""
        check_text("name", name)
        if sensor_id not in self._sensors:
            raise ServiceCallError(f"no sensor has the id {sensor_id!r:.100}; see: rostether sensor list")
        if self._sensors[sensor_id].origin is Origin.FILE:
            raise ServiceCallError(f"the name of {sensor_id} is set in sensors.toml; change it there")
        self._sensors[sensor_id] = replace(self._sensors[sensor_id], name=name)
        return self._sensors[sensor_id]

    def record_connection(self, sensor_id: str, is_connected: bool, now_s: float) -> None:
        """Record whether the sensor's topic has a publisher now."""
        self._conditions[sensor_id].record_connection(is_connected, now_s)

    def record_type(self, sensor_id: str, published: str) -> None:
        """Record the type of the sensor's topic, `*` if it is unknown."""
        expected = self._sensors[sensor_id].message_type
        is_right = not expected or published in (expected, "*")
        fault = "" if is_right else f"publishes {published:.100}, not {expected}"
        self._conditions[sensor_id].type_fault = fault

    def record_message(self, sensor_id: str, now_s: float) -> None:
        """Record a message of the sensor; ignores unknown sensors."""
        if (condition := self._conditions.get(sensor_id)) is not None:
            condition.is_connected = condition.was_connected = True
            condition.last_message_s = now_s

    def update_states(self, now_s: float) -> bool:
        """Update all states; return whether a state or a text has changed."""
        has_changed = False
        for key, condition in self._conditions.items():
            has_changed |= condition.update_state(self._sensors[key].is_camera, now_s)
        return has_changed

    def _add_counted(self, number: int, platform: str, sensor_type: str, now_s: float) -> Sensor:
        topic = f"sensor_node{number}"
        name = f"{platform} {sensor_type} {number}"
        sensor = Sensor(topic, number, platform, sensor_type, topic, name, MESSAGE_TYPES[sensor_type])
        self.add(sensor, now_s)
        self._next_number = max(self._next_number, number + 1)
        return sensor

    def _find_gone(self, platform: str, sensor_type: str) -> Sensor | None:
        for sensor in self._sensors.values():
            if (sensor.platform, sensor.sensor_type) == (platform, sensor_type) and sensor.number >= 0:
                condition = self._conditions[sensor.id]
                # A sensor that was never connected is new, and may be about to publish.
                if condition.was_connected and not condition.is_connected:
                    return sensor
        return None

    def _make_room(self) -> None:
        if len(self._sensors) < MAX_SENSORS:
            return
        lost = [key for key, each in self._conditions.items() if each.state == "lost"]
        if not lost:
            raise ServiceCallError(
                f"there are already {MAX_SENSORS} sensors; stop one, and try again when its state is lost"
            )
        oldest = min(lost, key=lambda key: self._conditions[key].since_s)
        del self._sensors[oldest], self._conditions[oldest]
