from __future__ import annotations

from typing import Any

import pytest
from msgspec.structs import replace

from rostether.errors import ServiceCallError
from rostether.platform import sensor_registry
from rostether.platform.sensor_registration import MAX_TEXT_CHARACTERS, Registration
from rostether.platform.sensor_registry import Sensor, SensorRegistry

CAMERA = Registration(
    id="robot3/front",
    instance="/camera on robot3",
    name="Front camera",
    platform="Robot 3",
    sensor_type="CAMERA",
    message_type="sensor_msgs/CompressedImage",
    rate_hz=5.0,
    lease_s=12.0,
)


@pytest.fixture
def registry() -> SensorRegistry:
    return SensorRegistry()


def state(registry: SensorRegistry, sensor_id: str, now_s: float) -> str:
    registry.update_states(now_s)
    return registry.state(sensor_id)[0]


def test_topics_count_from_0(registry: SensorRegistry) -> None:
    topics = [registry.register("Robot", each, 0.0).topic for each in ("CAMERA", "ANALOG", "ANALOG")]
    assert topics == ["sensor_node0", "sensor_node1", "sensor_node2"]
    assert [each.message_type for each in registry.sensors][:2] == [
        "sensor_msgs/CompressedImage",
        "std_msgs/Float64",
    ]


def test_states_by_age(registry: SensorRegistry) -> None:
    key = registry.register("Robot", "ANALOG", 0.0).id
    assert state(registry, key, 59.9) == "init"
    assert state(registry, key, 60.0) == "lost"
    registry.record_connection(key, True, 61.0)
    assert state(registry, key, 61.0) == "init"
    registry.record_message(key, 62.0)
    assert state(registry, key, 64.9) == "ready"
    assert state(registry, key, 65.0) == "sleeping"
    registry.record_connection(key, False, 70.0)
    assert state(registry, key, 70.0) == "disconnected"
    assert state(registry, key, 129.9) == "disconnected"
    assert state(registry, key, 130.0) == "lost"
    assert registry.state(key) == ("lost", "", 130.0)
    registry.record_message(key, 131.0)
    assert state(registry, key, 131.0) == "ready"
    # The message arrived after the report of the publisher's end.
    assert state(registry, key, 134.0) == "disconnected"


def test_a_camera_is_ready_without_pictures(registry: SensorRegistry) -> None:
    key = registry.register("Robot", "CAMERA", 0.0).id
    registry.record_connection(key, True, 1.0)
    assert state(registry, key, 100.0) == "ready"


def test_a_sensor_that_comes_back_is_itself(registry: SensorRegistry) -> None:
    first = registry.register("Robot", "ANALOG", 0.0)
    registry.rename(first.id, "Front distance")
    # Two of a kind that start together are two sensors.
    assert registry.register("Robot", "ANALOG", 0.1).topic == "sensor_node1"
    registry.record_message(first.id, 1.0)
    registry.record_connection(first.id, False, 2.0)
    assert registry.register("Robot", "DIGITAL", 3.0).topic == "sensor_node2"
    again = registry.register("Robot", "ANALOG", 3.0)
    assert (again.id, again.name) == (first.id, "Front distance")
    assert registry.register("Robot", "ANALOG", 3.1).topic == "sensor_node3"


def test_after_a_restart_numbers_continue() -> None:
    kept = Sensor("sensor_node4", 4, "Robot", "ANALOG", "sensor_node4", "Front", "std_msgs/Float64")
    registry = SensorRegistry([kept], 10.0)
    assert state(registry, kept.id, 10.0) == "disconnected"
    registry.record_connection(kept.id, True, 10.1)
    assert registry.register("Robot", "ANALOG", 11.0).topic == "sensor_node5"


@pytest.mark.parametrize(
    ("platform", "sensor_type", "reason"),
    [
        ("Robot", "RADAR", "sensor_type must be one of CAMERA, ANALOG, DIGITAL, not 'RADAR'"),
        ("", "ANALOG", "platform_name must be 1 to 100 printable characters"),
        ("a\nb", "ANALOG", "platform_name must be 1 to 100 printable characters"),
        ("x" * 101, "ANALOG", "platform_name must be 1 to 100 printable characters"),
    ],
)
def test_what_cannot_be_registered(
    registry: SensorRegistry, platform: str, sensor_type: str, reason: str
) -> None:
    with pytest.raises(ServiceCallError, match=reason):
        registry.register(platform, sensor_type, 0.0)


def test_what_cannot_be_renamed(registry: SensorRegistry) -> None:
    registry.add(Sensor("arm_range", -1, "arm", "ANALOG", "/arm/range", "Range"), 0.0)
    with pytest.raises(ServiceCallError, match="no sensor has the id 'x'"):
        registry.rename("x", "y")
    with pytest.raises(ServiceCallError, match="change it there"):
        registry.rename("arm_range", "y")


def test_the_number_of_sensors_is_limited(registry: SensorRegistry, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sensor_registry, "MAX_SENSORS", 2)
    registry.register("A", "ANALOG", 0.0)
    registry.register("B", "ANALOG", 1.0)
    with pytest.raises(ServiceCallError, match="there are already 2 sensors; stop one"):
        registry.register("C", "ANALOG", 2.0)
    registry.update_states(60.0)
    assert registry.register("C", "ANALOG", 60.0).topic == "sensor_node2"
    assert [each.platform for each in registry.sensors] == ["B", "C"]
    # A late message of the sensor that was replaced.
    registry.record_message("sensor_node0", 61.0)
    assert not registry.is_ready("sensor_node0")


def test_a_sensor_with_an_id_reports_its_state(registry: SensorRegistry) -> None:
    sensor, refusal = registry.register_by_id(CAMERA, 0.0)
    assert (sensor.topic, sensor.name, refusal) == ("/sensors/robot3/front", "Front camera", "")
    assert state(registry, sensor.id, 0.0) == "init"
    registry.record_connection(sensor.id, True, 1.0)
    assert state(registry, sensor.id, 1.0) == "ready"
    registry.register_by_id(replace(CAMERA, state="alert", state_text="no camera"), 4.0)
    assert registry.update_states(4.0)
    assert registry.state(sensor.id) == ("alert", "no camera", 4.0)
    registry.register_by_id(replace(CAMERA, state="alert", state_text="no light"), 8.0)
    assert registry.update_states(8.0)
    assert registry.state(sensor.id) == ("alert", "no light", 4.0)
    # The robot is switched off: the graph still lists its publisher.
    assert state(registry, sensor.id, 19.9) == "alert"
    assert state(registry, sensor.id, 20.0) == "lost"
    assert registry.state(sensor.id)[1] == ""
    registry.register_by_id(CAMERA, 30.0)
    assert state(registry, sensor.id, 30.0) == "ready"
    registry.record_connection(sensor.id, False, 31.0)
    assert state(registry, sensor.id, 31.0) == "disconnected"


def test_the_name_given_last_is_valid(registry: SensorRegistry) -> None:
    registry.register_by_id(CAMERA, 0.0)
    registry.rename("robot3/front", "Eye")
    assert registry.register_by_id(CAMERA, 1.0)[0].name == "Eye"
    assert registry.register_by_id(replace(CAMERA, name="Camera"), 2.0)[0].name == "Camera"
    # As saved, and restored by the next manager.
    again = SensorRegistry(registry.sensors, 10.0)
    again.rename("robot3/front", "Eye")
    assert again.register_by_id(replace(CAMERA, name="Camera"), 10.1)[0].name == "Eye"


def test_one_node_holds_the_lease_of_an_id(registry: SensorRegistry) -> None:
    other = replace(CAMERA, instance="/camera on robot4")
    registry.register_by_id(CAMERA, 0.0)
    registry.record_connection(CAMERA.id, True, 1.0)
    refusal = registry.register_by_id(other, 2.0)[1]
    assert refusal == "/camera on robot3 is registered as robot3/front for 10 s more"
    # Its publisher has gone, or its lease has passed.
    registry.record_connection(CAMERA.id, False, 3.0)
    assert registry.register_by_id(other, 3.0)[1] == ""
    registry.record_connection(CAMERA.id, True, 4.0)
    assert registry.register_by_id(CAMERA, 14.9)[1] != ""
    assert registry.register_by_id(CAMERA, 15.0)[1] == ""


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"id": "robot 3"}, "id must be a name such as robot3/front, not 'robot 3'"),
        ({"id": "sensor_node0"}, "sensor_node0 exists and has no lease"),
        ({"sensor_type": "radar"}, "sensor_type must be a word such as ANALOG, not 'radar'"),
        ({"message_type": "Float64"}, "message_type must be a type such as std_msgs/Float64"),
        ({"lease_s": 0.0}, "lease_s must be 1 to 3600, not 0"),
        ({"lease_s": float("nan")}, "lease_s must be 1 to 3600, not nan"),
        ({"rate_hz": -1.0}, "rate_hz must be 0"),
        ({"state": "fine"}, "state must be one of init, ready, sleeping, alert, not 'fine'"),
        ({"platform": ""}, "platform_name must be 1 to 100 printable characters"),
        ({"unit": "a\nb"}, "unit must be 1 to 100 printable characters"),
    ],
)
def test_what_cannot_be_registered_by_id(
    registry: SensorRegistry, change: dict[str, Any], reason: str
) -> None:
    registry.register("Robot", "ANALOG", 0.0)
    with pytest.raises(ServiceCallError, match=reason):
        registry.register_by_id(replace(CAMERA, **change), 0.0)
    assert len(registry.sensors) == 1


@pytest.mark.parametrize("sensor_type", ["CAMERA", "ANALOG"])
def test_a_topic_with_another_type_is_an_alert(registry: SensorRegistry, sensor_type: str) -> None:
    sensor = registry.register("Robot", sensor_type, 0.0)
    registry.record_connection(sensor.id, True, 1.0)
    registry.record_type(sensor.id, "std_msgs/Float32")
    registry.record_message(sensor.id, 1.0)
    assert state(registry, sensor.id, 1.0) == "alert"
    assert registry.state(sensor.id)[1] == f"publishes std_msgs/Float32, not {sensor.message_type}"
    for known in ("*", sensor.message_type):
        registry.record_type(sensor.id, known)
        assert state(registry, sensor.id, 1.0) == "ready"
        assert registry.state(sensor.id)[1] == ""
    registry.record_type(sensor.id, "std_msgs/Float32")
    registry.record_connection(sensor.id, False, 1.0)
    assert state(registry, sensor.id, 9.0) == "disconnected"


def test_sensors_of_an_earlier_manager_are_adopted(registry: SensorRegistry) -> None:
    registry.adopt("sensor_node4", "sensor_msgs/CompressedImage", "pi_camera", 0.0)
    registry.adopt("sensor_nodes", "std_msgs/Float64", "x", 0.0)
    assert [(each.id, each.sensor_type) for each in registry.sensors] == [("sensor_node4", "CAMERA")]
    assert registry.register("Robot", "ANALOG", 1.0).topic == "sensor_node5"


def test_other_spellings_of_a_numbered_topic_replace_no_sensor(registry: SensorRegistry) -> None:
    taken = registry.register("Robot", "ANALOG", 0.0)
    for topic in ("sensor_node00", "sensor_node\u0660"):
        registry.adopt(topic, "std_msgs/Float64", "x", 0.0)
    with pytest.raises(ServiceCallError, match="sensor_node1 is reserved"):
        registry.register_by_id(replace(CAMERA, id="sensor_node1"), 0.0)
    assert registry.sensors == (taken,)


def test_the_platform_of_an_adopted_sensor_is_a_short_printable_text(registry: SensorRegistry) -> None:
    registry.adopt("sensor_node1", "std_msgs/Float64", "\x1b[2J" + "x" * 1000, 0.0)
    assert registry.sensors[0].platform.isprintable()
    assert len(registry.sensors[0].platform) == MAX_TEXT_CHARACTERS
