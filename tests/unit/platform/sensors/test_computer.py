"""The battery and the load of a robot's computer, from trees of files like those of Linux."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from rostether.errors import SensorError
from rostether.platform.sensors.battery import MESSAGE_TYPE, find_battery, publish_battery, read_battery
from rostether.platform.sensors.system_load import SystemFiles, SystemLoad, publish_system_load
from unit.platform.datagrams import running
from unit.platform.sensors.shown_sensors import described, shown_sensors
from waiting import until

BATTERY = {
    "type": "Battery",
    "status": "Discharging",
    "capacity": "42",
    "voltage_now": "11100000",
    "voltage_min_design": "10000000",
    "power_now": "5550000",
    "energy_now": "20000000",
    "energy_full": "40000000",
    "energy_full_design": "50000000",
    "health": "Good",
    "technology": "Li-ion",
    "temp": "305",
    "present": "1",
    "serial_number": "A1",
}


def tree(folder: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"{text}\n")
    return folder


def test_a_battery(tmp_path: Path) -> None:
    tree(tmp_path / "AC", {"type": "Mains"})
    mouse = tree(tmp_path / "A-mouse", {"type": "Battery", "scope": "Device"})
    with pytest.raises(SensorError, match="has no battery"):
        find_battery(tmp_path)
    supply = tree(tmp_path / "BAT0", BATTERY)
    assert find_battery(tmp_path) == supply
    found = read_battery(supply)
    numbers = ("voltage", "current", "charge", "capacity", "design_capacity", "percentage", "temperature")
    assert [found[each] for each in numbers] == [11.1, -0.5, 2.0, 4.0, 5.0, 0.42, 30.5]
    assert [found[f"power_supply_{each}"] for each in ("status", "health", "technology")] == [2, 1, 2]
    assert found["present"] is True
    assert math.isnan(read_battery(mouse)["voltage"])


async def test_a_battery_that_gets_low(tmp_path: Path) -> None:
    supply = tree(tmp_path / "BAT0", BATTERY)
    what = described("BATTERY", MESSAGE_TYPE)
    received: list[Any] = []
    async with (
        shown_sensors() as shown,
        running(publish_battery(shown.robot, what, supply, 0.15, shown.report)),
    ):
        await shown.viewer.subscriber(what.topic, MESSAGE_TYPE, received.append)
        await shown.has_state(what.id, "ready")
        tree(supply, {"capacity": "9"})
        await shown.has_state(what.id, "alert below 15%")
        # Some drivers report only the charge, and some nothing.
        (supply / "capacity").unlink()
        await shown.has_state(what.id, "ready")
        (supply / "energy_now").unlink()
        await shown.has_state(what.id, "alert its driver does not report the charge")
        tree(supply, {"capacity": "9", "status": "Charging"})
        await shown.has_state(what.id, "ready")
        await until(lambda: received and received[-1].power_supply_status == 1)


async def test_the_load_of_a_computer(tmp_path: Path) -> None:
    files = SystemFiles(tmp_path / "proc", tmp_path / "thermal", tmp_path)
    tree(
        tmp_path,
        {
            "proc/stat": "cpu 10 0 10 70 10 0 0 0 5 0\ncpu0 1 2",
            "proc/meminfo": "MemTotal: 1000 kB\nMemFree: 1 kB\nMemAvailable: 250 kB",
            "thermal/thermal_zone0/temp": "45000",
            "thermal/thermal_zone1/temp": "81500",
        },
    )
    load = SystemLoad(files)
    assert load.cpu() == pytest.approx(20.0)
    tree(tmp_path, {"proc/stat": "cpu 60 0 10 110 20 0 0 0 5 0"})
    assert load.cpu() == pytest.approx(50.0)
    assert load.memory() == 75.0
    assert 0 < load.disk() <= 100
    async with (
        shown_sensors() as shown,
        running(publish_system_load(shown.robot, "Robot 3", "Robot_3", 100.0, files, shown.report)),
    ):
        await shown.has_state("Robot_3/temperature", "alert above 80 \N{DEGREE SIGN}C")
        await shown.has_state("Robot_3/memory", "ready")
        tree(tmp_path, {"proc/stat": "none"})
        await until(lambda: "does not start with cpu" in shown.state("Robot_3/cpu"))


def test_the_load_of_this_computer() -> None:
    load = SystemLoad(SystemFiles())
    assert 0 <= load.cpu() <= 100
    assert 0 < load.memory() < 100
