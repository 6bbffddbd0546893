// The unit of a field: from the comment of its definition, else the one that ROS defines for the type (REP 103).

import { parsePath } from "../wire/path.ts";
import type { Node, StructNode } from "../wire/schema.ts";

/** Units by type and field; a field that is a message gives its unit to the numbers within. */
const UNITS: Record<string, string> = {
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
};

// `[m]`, `[rad/s]`, `(in m/s^2)`, as definitions write units.
const BRACKETS = /[[(](?:in )?([a-zA-Z°µ%][a-zA-Z0-9°µ%/^*²]{0,8})[\])]/;
const KNOWN =
  /^(m|mm|cm|km|s|ms|us|µs|ns|rad|deg|°|°C|C|K|V|mV|A|mA|Ah|W|N|Nm|N\*m|Pa|hPa|kPa|T|Hz|%|g|kg|lx|lux|rpm|ppm|dB|(m|cm|mm|km|rad|deg|°)\/(s|h|s\^2|s²|sec))$/;

/** Returns the unit of the number at a path, empty when it is not known. */
export function unitOf(type: StructNode, path: string): string {
  let node: Node = type;
  let unit = "";
  for (const step of parsePath(path)) {
    if (node.kind === "array") {
      node = node.element;
      continue;
    }
    if (node.kind !== "struct") break;
    const struct: StructNode = node;
    const field = struct.fields.find((each) => each.name === step);
    if (!field) return "";
    unit = UNITS[`${struct.name} ${field.name}`] ?? unitOfComment(field.comment) ?? unit;
    node = field.node;
  }
  return unit;
}

function unitOfComment(comment: string): string | undefined {
  const found = BRACKETS.exec(comment)?.[1];
  return found && KNOWN.test(found) ? found.replace("^2", "²").replace("N*m", "Nm") : undefined;
}
