from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rostether.errors import ConfigError, SensorError
from rostether.platform.sensors import readings
from rostether.platform.sensors.gpio_line import GpioLine
from rostether.platform.sensors.number_file import NumberFile
from rostether.platform.sensors.value import MESSAGE_TYPE, Scaling, TopicField, publish_values
from unit.platform.datagrams import running
from unit.platform.sensors.shown_sensors import described, shown_sensors
from waiting import until


def test_a_converter_of_the_system_in_its_unit(tmp_path: Path) -> None:
    raw = tmp_path / "in_voltage0_raw"
    raw.write_text("1000\n")
    (tmp_path / "in_voltage_scale").write_text("2.5\n")
    assert (NumberFile(raw).read(), NumberFile(raw).unit) == (2.5, "V")
    # The channel's own, before that of its kind.
    (tmp_path / "in_voltage0_offset").write_text("-200\n")
    (tmp_path / "in_voltage0_scale").write_text("5\n")
    assert NumberFile(raw).read() == 4.0
    distance = tmp_path / "in_distance_input"
    distance.write_text("1.25\n")
    assert (NumberFile(distance).read(), NumberFile(distance).unit) == (1.25, "m")
    plain = tmp_path / "value"
    plain.write_text("7 of 9\n")
    assert (NumberFile(plain).read(), NumberFile(plain).unit) == (7.0, "")
    plain.write_text("none\n")
    with pytest.raises(SensorError, match="value does not start with a number, but with 'none"):
        NumberFile(plain).read()


def replace_text(file: Path, text: str) -> None:
    """Write a file in one step: a reader never finds it empty, as with those of the system."""
    fresh = file.with_suffix(".fresh")
    fresh.write_text(text)
    fresh.replace(file)


async def test_a_file_that_goes_and_comes_back(tmp_path: Path) -> None:
    file = tmp_path / "value"
    what = described("ANALOG", MESSAGE_TYPE, unit="V")
    scaling = Scaling(scale=2.0, offset=1.0, alert_above=10.0)
    values: list[float] = []
    async with shown_sensors() as shown:
        await shown.viewer.subscriber(what.topic, MESSAGE_TYPE, lambda m: values.append(m.data))
        async with running(
            publish_values(shown.robot, what, lambda: NumberFile(file).readings(100), scaling, shown.report)
        ):
            await shown.has_state(what.id, f"alert {file}: No such file or directory")
            replace_text(file, "3")
            await until(lambda: values[-1:] == [7.0])
            await shown.has_state(what.id, "ready")
            replace_text(file, "5")
            await shown.has_state(what.id, "alert above 10 V")
            replace_text(file, "nan")
            await shown.has_state(what.id, "alert not a number")
    reason = f"{file}: No such file or directory; choose another ~path, ~gpio or ~field"
    failed = f"{what.id}: {reason}; trying again every second"
    texts = [each for each in shown.report.texts if "registered" not in each]
    assert texts == [failed, f"{what.id} works again"]


async def test_a_boards_topic_as_a_sensor() -> None:
    what = described("ANALOG", MESSAGE_TYPE, unit="m")
    async with shown_sensors() as shown:
        board = await shown.viewer.publisher("/arm/ultrasound", "sensor_msgs/Range")
        values: list[float] = []
        await shown.viewer.subscriber(what.topic, MESSAGE_TYPE, lambda m: values.append(m.data))
        async with running(
            publish_values(
                shown.robot,
                what,
                TopicField(shown.robot, "/arm/ultrasound", "range").values,
                Scaling(),
                shown.report,
            )
        ):
            await shown.has_state(what.id, "init")
            await until(lambda: board.subscriber_count)
            board.publish(range=0.5)
            await shown.has_state(what.id, "ready")
            await until(lambda: values == [0.5])
            # Another sketch, and then the first one again.
            await board.close()
            other = await shown.viewer.publisher("/arm/ultrasound", "std_msgs/String", latch=True)
            other.publish(data="far")
            await shown.has_state(what.id, "alert std_msgs/String has no field 'range'; it has data")
            await other.close()
            board = await shown.viewer.publisher("/arm/ultrasound", "sensor_msgs/Range", latch=True)
            board.publish(range=0.75)
            await shown.has_state(what.id, "ready")
            await until(lambda: values == [0.5, 0.75])


async def test_a_topic_that_does_not_exist(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(readings, "SILENT_S", 0.01)
    what = described("ANALOG", MESSAGE_TYPE)
    async with shown_sensors() as shown:
        source = TopicField(shown.robot, "arm/ultrasond", "data")
        work = publish_values(
            shown.robot, what, source.values, Scaling(), shown.report, silence=source.silence
        )
        async with running(work):
            reason = "no message on /arm/ultrasond; check its name: rostether topic list"
            await shown.has_state(what.id, f"init {reason}")
            assert f"{what.id}: {reason}" in shown.report.texts
            board = await shown.viewer.publisher("/arm/ultrasond", MESSAGE_TYPE, latch=True)
            board.publish(data=1.0)
            await shown.has_state(what.id, f"sleeping {reason}")


@pytest.mark.parametrize(
    ("field", "reason"),
    [
        ("distance", "has no field 'distance'"),
        ("header/frame_id", "frame_id of sensor_msgs/Range is not a number"),
    ],
)
async def test_a_field_that_is_not_a_number(field: str, reason: str) -> None:
    async with shown_sensors() as shown:
        board = await shown.viewer.publisher("/range", "sensor_msgs/Range", latch=True)
        board.publish(range=0.5)
        with pytest.raises(ConfigError, match=reason):
            await anext(TopicField(shown.robot, "/range", field).values())


async def test_a_gpio_line_that_is_missing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("gpiod")
    # A superscript is a digit, but it is not a number.
    for name in ("17", "GPIO17", "²"):
        line = GpioLine(name, str(tmp_path / "gpiochip0"))
        with pytest.raises(SensorError, match=f"gpiochip0: line {name} cannot be read: No such file"):
            await anext(line.levels())
    monkeypatch.setitem(sys.modules, "gpiod", None)
    with pytest.raises(ConfigError, match=r"GPIO lines need another package; run: .*rostether\[gpio\]"):
        await anext(line.levels())
