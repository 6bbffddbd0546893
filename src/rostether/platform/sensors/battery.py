"""The node battery: a power supply of Linux as sensor_msgs/BatteryState.

Source: Linux, Documentation/ABI/testing/sysfs-class-power. Values there are in millionths of the unit.
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

from rostether.errors import SensorError
from rostether.graph.ports import Report
from rostether.graph.typed_graph import TypedGraph
from rostether.platform.sensor_registration import SensorDescription
from rostether.platform.sensors.readings import paced, publish_readings
from rostether.platform.sensors.registered_sensor import registered_sensor

MESSAGE_TYPE = "sensor_msgs/BatteryState"
FOLDER = Path("/sys/class/power_supply")

# The largest text that Linux returns for one of these files: a page of memory.
_MAX_FILE_BYTES = 4096
_DISCHARGING = 2
_STATUS = {"Charging": 1, "Discharging": _DISCHARGING, "Not charging": 3, "Full": 4}
_HEALTH = {
    "Good": 1,
    "Overheat": 2,
    "Dead": 3,
    "Over voltage": 4,
    "Unspecified failure": 5,
    "Cold": 6,
    "Watchdog timer expire": 7,
    "Safety timer expire": 8,
}
_TECHNOLOGY = {"NiMH": 1, "Li-ion": 2, "Li-poly": 3, "LiFe": 4, "NiCd": 5, "LiMn": 6}


def find_battery(folder: Path = FOLDER) -> Path:
    """Return the folder of the first battery. Raises SensorError if there is no battery."""
    for supply in sorted(folder.glob("*")):
        if _text(supply, "type") == "Battery" and _text(supply, "scope") != "Device":
            return supply
    raise SensorError(f"{folder} has no battery")


def read_battery(supply: Path) -> dict[str, Any]:
    """Return the fields of sensor_msgs/BatteryState, NaN for values that the driver does not measure.

    Raises OSError if the battery was removed.
    """
    supply.stat()
    voltage = _micro(supply, "voltage_now")
    current = _micro(supply, "current_now")
    if math.isnan(current):
        current = _micro(supply, "power_now") / voltage if voltage else math.nan
    status = _STATUS.get(_text(supply, "status"), 0)
    if status == _DISCHARGING:
        # Drivers differ in the sign; in ROS, a discharging battery has a negative current.
        current = -abs(current)
    charge, capacity = _charge(supply, "now"), _charge(supply, "full")
    percentage = _number(supply, "capacity") / 100
    if math.isnan(percentage) and capacity:
        percentage = charge / capacity
    return {
        "voltage": voltage,
        "temperature": _number(supply, "temp") / 10,
        "current": current,
        "charge": charge,
        "capacity": capacity,
        "design_capacity": _charge(supply, "full_design"),
        "percentage": percentage,
        "power_supply_status": status,
        "power_supply_health": _HEALTH.get(_text(supply, "health"), 0),
        "power_supply_technology": _TECHNOLOGY.get(_text(supply, "technology"), 0),
        "present": _text(supply, "present") != "0",
        "location": supply.name,
        "serial_number": _text(supply, "serial_number"),
    }


async def publish_battery(
    graph: TypedGraph,
    description: SensorDescription,
    supply: Path | None,
    alert_below: float,
    report: Report,
) -> None:
    """Publish a battery as a sensor until canceled; without `supply`, the first one. Raises GraphError.

    The sensor is in alert while the battery discharges below `alert_below`, a fraction of 1.
    """
    async with registered_sensor(graph, description, report) as sensor:

        def publish(fields: dict[str, Any]) -> None:
            sensor.publish(header=sensor.header(), **fields)
            is_low = fields["percentage"] < alert_below and fields["power_supply_status"] in (0, _DISCHARGING)
            text = f"below {alert_below:.0%}" if is_low else ""
            if math.isnan(fields["percentage"]):
                # Otherwise an empty battery would look like a full one.
                text = "its driver does not report the charge"
            sensor.set_state("alert" if text else "ready", text)

        def read() -> dict[str, Any]:
            return read_battery(supply if supply is not None else find_battery())

        readings = partial(paced, read, description.rate_hz)
        await publish_readings(sensor, readings, publish, hint="choose a folder of a battery with ~path")


def _charge(supply: Path, which: str) -> float:
    charge = _micro(supply, f"charge_{which}")
    if math.isnan(charge):
        # Some drivers report energy instead; dividing by the design voltage gives the charge.
        energy, voltage = _micro(supply, f"energy_{which}"), _micro(supply, "voltage_min_design")
        return energy / voltage if voltage else math.nan
    return charge


def _micro(supply: Path, name: str) -> float:
    return _number(supply, name) / 1e6


def _number(supply: Path, name: str) -> float:
    try:
        return float(_text(supply, name))
    except ValueError:
        return math.nan


def _text(supply: Path, name: str) -> str:
    # A driver returns an error for a property that it cannot measure now.
    try:
        with (supply / name).open("rb") as file:
            return file.read(_MAX_FILE_BYTES).decode(errors="replace").strip()
    except OSError:
        return ""
