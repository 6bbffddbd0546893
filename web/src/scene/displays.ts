// Which display draws which message type.
import type { MakeDisplay } from "./display.ts";
import type { DisplayType } from "./display_types.ts";
import { GridDisplay, OdometryDisplay, PathDisplay, PoseArrayDisplay, PoseDisplay } from "./geometry.ts";
import { MarkerDisplay } from "./markers.ts";
import { ImuDisplay, LaserScanDisplay, PointCloudDisplay, PointDisplay, RangeDisplay } from "./sensors.ts";

export const DISPLAYS: Readonly<Record<DisplayType, MakeDisplay>> = {
  "geometry_msgs/PointStamped": (context) => new PointDisplay(context),
  "geometry_msgs/PoseArray": (context) => new PoseArrayDisplay(context),
  "geometry_msgs/PoseStamped": (context) => new PoseDisplay(context),
  "geometry_msgs/PoseWithCovarianceStamped": (context) => new PoseDisplay(context),
  "nav_msgs/OccupancyGrid": (context) => new GridDisplay(context),
  "nav_msgs/Odometry": (context) => new OdometryDisplay(context),
  "nav_msgs/Path": (context) => new PathDisplay(context),
  "sensor_msgs/Imu": (context) => new ImuDisplay(context),
  "sensor_msgs/LaserScan": (context) => new LaserScanDisplay(context),
  "sensor_msgs/PointCloud2": (context) => new PointCloudDisplay(context),
  "sensor_msgs/Range": (context) => new RangeDisplay(context),
  "visualization_msgs/Marker": (context) => new MarkerDisplay(context),
  "visualization_msgs/MarkerArray": (context) => new MarkerDisplay(context),
};
