// The most important fields of a type: for cards, and for a message in one line.

const XYZ = (path: string) => ["x", "y", "z"].map((axis) => `${path}.${axis}`);
export const MAIN_FIELDS: Record<string, string[]> = {
  "sensor_msgs/Range": ["range"],
  "sensor_msgs/Imu": XYZ("angular_velocity"),
  "sensor_msgs/MagneticField": XYZ("magnetic_field"),
  "sensor_msgs/BatteryState": ["voltage"],
  "sensor_msgs/Temperature": ["temperature"],
  "sensor_msgs/RelativeHumidity": ["relative_humidity"],
  "sensor_msgs/FluidPressure": ["fluid_pressure"],
  "sensor_msgs/Illuminance": ["illuminance"],
  "sensor_msgs/Joy": ["axes[0]", "axes[1]"],
  "sensor_msgs/JointState": ["position[0]", "position[1]", "position[2]", "position[3]"],
  "geometry_msgs/Twist": ["linear.x", "angular.z"],
  "geometry_msgs/TwistStamped": ["twist.linear.x", "twist.angular.z"],
  "geometry_msgs/Vector3": ["x", "y", "z"],
  "geometry_msgs/Vector3Stamped": XYZ("vector"),
  "geometry_msgs/WrenchStamped": XYZ("wrench.force"),
  "nav_msgs/Odometry": ["twist.twist.linear.x", "twist.twist.angular.z"],
};
