"""The units of numbers in messages, by their type and field, or by the comment in the definition."""

from __future__ import annotations

import re
from typing import Final

from rostether.errors import DefinitionError
from rostether.msgdef.registry import Registry
from rostether.serde.type_tree import Array, Node, Struct

# By type and field; a field that is a message gives its unit to the numbers in it.
UNITS: Final = {
    "geometry_msgs/Twist linear": "m/s",
    "geometry_msgs/Twist angular": "rad/s",
    "geometry_msgs/Accel linear": "m/s²",
    "geometry_msgs/Accel angular": "rad/s²",
    "geometry_msgs/Wrench force": "N",
    "geometry_msgs/Wrench torque": "Nm",
    "geometry_msgs/Pose position": "m",
    "geometry_msgs/PointStamped point": "m",
    "geometry_msgs/Transform translation": "m",
    "sensor_msgs/Range range": "m",
    "sensor_msgs/Range min_range": "m",
    "sensor_msgs/Range max_range": "m",
    "sensor_msgs/Range field_of_view": "rad",
    "sensor_msgs/LaserScan ranges": "m",
    "sensor_msgs/LaserScan angle_min": "rad",
    "sensor_msgs/LaserScan angle_max": "rad",
    "sensor_msgs/LaserScan angle_increment": "rad",
    "sensor_msgs/LaserScan scan_time": "s",
    "sensor_msgs/Imu angular_velocity": "rad/s",
    "sensor_msgs/Imu linear_acceleration": "m/s²",
    "sensor_msgs/MagneticField magnetic_field": "T",
    "sensor_msgs/Temperature temperature": "°C",
    "sensor_msgs/FluidPressure fluid_pressure": "Pa",
    "sensor_msgs/Illuminance illuminance": "lx",
    "sensor_msgs/BatteryState voltage": "V",
    "sensor_msgs/BatteryState current": "A",
    "sensor_msgs/BatteryState charge": "Ah",
    "sensor_msgs/BatteryState capacity": "Ah",
    "sensor_msgs/BatteryState temperature": "°C",
    "sensor_msgs/NavSatFix latitude": "°",
    "sensor_msgs/NavSatFix longitude": "°",
    "sensor_msgs/NavSatFix altitude": "m",
    "sensor_msgs/JointState position": "rad",
    "sensor_msgs/JointState velocity": "rad/s",
    "sensor_msgs/JointState effort": "Nm",
}

# Units in the comments of definitions: `[m]`, `[rad/s]`, `(in m/s^2)`.
_BRACKETS = re.compile(r"[\[(](?:in )?([a-zA-Z°µ%][a-zA-Z0-9°µ%/^*²]{0,8})[\])]")
_KNOWN = re.compile(
    r"m|mm|cm|km|s|ms|us|µs|ns|rad|deg|°|°C|C|K|V|mV|A|mA|Ah|W|N|Nm|N\*m|Pa|hPa|kPa|T|Hz|%|g|kg|lx|lux|rpm"
    r"|ppm|dB|(m|cm|mm|km|rad|deg|°)/(s|h|s\^2|s²|sec)"
)


def unit_of(registry: Registry, tree: Struct, path: str) -> str:
    """Return the unit of the number at a path (`position[0]`, `twist/linear/x`), empty if it is unknown."""
    node: Node = tree
    unit = ""
    for step in re.findall(r"[^/\[\].]+", path):
        if isinstance(node, Array):
            node = node.element
        if not isinstance(node, Struct):
            # An index, or a path beyond the definition.
            break
        found = next((each for each in node.members if each.name == step), None)
        if found is not None:
            unit = UNITS.get(f"{node.name} {step}") or _of_comment(registry, node.name, step) or unit
            node = found.node
    return unit


def _of_comment(registry: Registry, type_name: str, field: str) -> str:
    try:
        text = registry.message(type_name).text
    except DefinitionError:
        return ""
    line = re.search(rf"^\s*\S+\s+{re.escape(field)}\s*#(.*)$", text, re.MULTILINE)
    found = _BRACKETS.search(line[1]) if line else None
    if found is None or not _KNOWN.fullmatch(found[1]):
        return ""
    return found[1].replace("^2", "²").replace("N*m", "Nm")
