// What of a topic is worth a plot on the overview.
import type { Topic } from "../../store/topics.ts";
import { numericPaths } from "../../wire/path.ts";
import type { Graph, Suggestion } from "../panel.ts";

const XYZ = (path: string) => ["x", "y", "z"].map((axis) => `${path}.${axis}`);
const MAIN: Record<string, string[]> = {
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
/** Packages whose other messages are of no use as a plot, or are shown by other panels. */
const OTHER =
  /^(sensor_msgs|geometry_msgs|nav_msgs|visualization_msgs|tf2?_msgs|tf|actionlib_msgs|diagnostic_msgs|rosgraph_msgs|std_srvs|shape_msgs|stereo_msgs|trajectory_msgs|bond|dynamic_reconfigure)\//;
const MAX_PATHS = 3;
const MAX_CARDS = 16;

/** The paths of a topic to plot first; none when it has no number that people would look at. */
export function mainPaths(topic: Topic): string[] {
  const known = MAIN[topic.typeName];
  if (known) return known;
  if (OTHER.test(topic.typeName)) return [];
  try {
    return numericPaths(topic.type(), 20)
      .filter((path) => !path.endsWith("[:]"))
      .slice(0, MAX_PATHS);
  } catch {
    return [];
  }
}

export function plotSuggestions({ topics }: Graph): Suggestion[] {
  const found: Suggestion[] = [];
  for (const topic of topics.values()) {
    if (!topic.isPublished) continue;
    const paths = mainPaths(topic);
    if (paths.length === 0) continue;
    const series = paths.map((path) => `${topic.name}.${path}`);
    found.push({
      key: topic.name,
      title: topic.name,
      settings: { series },
      order: topic.typeName in MAIN ? 30 : 35,
    });
  }
  // Sensors first: a counter says less.
  return found.sort((a, b) => a.order - b.order || (a.key < b.key ? -1 : 1)).slice(0, MAX_CARDS);
}
