// The messages that a phone publishes; constants are omitted. Source: sensor_msgs of ROS 1.
import { parseDefinition } from "../wire/definition.ts";
import type { StructNode } from "../wire/schema.ts";

const LINE = `\n${"=".repeat(80)}\n`;
const HEADER = `${LINE}MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id`;
const DEFINITIONS = {
  "sensor_msgs/Imu": `Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance${HEADER}${LINE}MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w${LINE}MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z`,
  "sensor_msgs/NavSatFix": `Header header
NavSatStatus status
float64 latitude
float64 longitude
float64 altitude
float64[9] position_covariance
uint8 position_covariance_type${HEADER}${LINE}MSG: sensor_msgs/NavSatStatus
int8 status
uint16 service`,
  "sensor_msgs/CompressedImage": `Header header
string format
uint8[] data${HEADER}`,
  "sensor_msgs/BatteryState": `Header header
float32 voltage
float32 temperature
float32 current
float32 charge
float32 capacity
float32 design_capacity
float32 percentage
uint8 power_supply_status
uint8 power_supply_health
uint8 power_supply_technology
bool present
float32[] cell_voltage
float32[] cell_temperature
string location
string serial_number${HEADER}`,
};

export type PhoneType = keyof typeof DEFINITIONS;

export function phoneType(name: PhoneType): StructNode {
  return parseDefinition(name, DEFINITIONS[name]);
}
