from __future__ import annotations

import json
from pathlib import Path

import pytest
from msgspec.structs import replace

from rostether.errors import ConfigError
from rostether.platform.sensor_files import read_sensors_toml, read_state, write_state
from rostether.platform.sensor_registration import MAX_TEXT_CHARACTERS
from rostether.platform.sensor_registry import MAX_SENSORS, Sensor

KEPT = Sensor("sensor_node4", 4, "Robot", "ANALOG", "sensor_node4", "Front", "std_msgs/Float64")


def test_a_line_makes_a_topic_a_sensor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLATFORM_NAME", "Robot3")
    file = tmp_path / "sensors.toml"
    file.write_text(
        '"/arm/ultrasound" = { name = "Distance", unit = "m" }\n'
        '"/light" = { type = "DIGITAL" }\n'
        '"/cam/image" = { type = "CAMERA", platform = "Drone" }\n'
    )
    assert read_sensors_toml(file) == [
        Sensor("arm/ultrasound", -1, "arm", "ANALOG", "/arm/ultrasound", "Distance", unit="m"),
        Sensor("light", -1, "Robot3", "DIGITAL", "/light", "/light"),
        Sensor("cam/image", -1, "Drone", "CAMERA", "/cam/image", "/cam/image"),
    ]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x", "not TOML"),
        ('"a b" = {}', "a b"),
        ('"arm/x" = {}', 'write the topic "arm/x" with a slash'),
        ('"/x" = 1', 'write "/x" = { name ='),
        ('"/x" = { colour = "red" }', "unknown key 'colour'; known: name, platform, type, unit"),
        ('"/x" = { name = 1 }', "name of /x must be text"),
        ('"/x" = { type = "RADAR" }', "type of /x must be one of CAMERA, ANALOG, DIGITAL, not 'RADAR'"),
        ('"/sensor_node1" = {}', "belongs to a registered sensor"),
    ],
)
def test_what_is_wrong_in_the_file(tmp_path: Path, text: str, reason: str) -> None:
    file = tmp_path / "sensors.toml"
    file.write_text(text)
    with pytest.raises(ConfigError) as error:
        read_sensors_toml(file)
    assert str(error.value).startswith(f"{file}: ")
    assert reason in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_that_is_missing(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="No such file or directory; check the path"):
        read_sensors_toml(tmp_path / "sensors.toml")


def test_the_state_is_read_as_written(tmp_path: Path) -> None:
    path = tmp_path / "below" / "sensors.json"
    by_id = Sensor(
        "a/b", -1, "A", "GPS", "sensors/a/b", "B", "sensor_msgs/NavSatFix", rate_hz=5, lease_s=12.5
    )
    write_state(path, [KEPT, by_id])
    assert read_state(path) == [KEPT, by_id]
    assert [each.name for each in path.parent.iterdir()] == ["sensors.json"]


def test_the_longest_state_is_read_again(tmp_path: Path) -> None:
    long = "\U0001f916" * MAX_TEXT_CHARACTERS
    sensors = [replace(KEPT, id=f"s{number}", name=long, platform=long) for number in range(MAX_SENSORS)]
    write_state(tmp_path / "sensors.json", sensors)
    assert read_state(tmp_path / "sensors.json") == sensors


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{", '{"format": 2}', '{"format": 1, "sensors": 3}', '{"format": 1, "sensors": [3, {}]}'],
)
def test_a_damaged_state_is_as_none(tmp_path: Path, content: str) -> None:
    path = tmp_path / "sensors.json"
    assert read_state(path) == []
    path.write_text(content)
    assert read_state(path) == []


def test_what_is_whole_in_a_state_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "sensors.json"
    write_state(path, [KEPT])
    content = json.loads(path.read_text())
    content["sensors"].insert(0, {"id": 3})
    path.write_text(json.dumps(content))
    assert read_state(path) == [KEPT]
