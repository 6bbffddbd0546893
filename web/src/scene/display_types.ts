// The message types that the 3D view draws. They are not beside the drawing code, so that this code loads only on first use.
export const DISPLAY_TYPES = [
  "geometry_msgs/PointStamped",
  "geometry_msgs/PoseArray",
  "geometry_msgs/PoseStamped",
  "geometry_msgs/PoseWithCovarianceStamped",
  "nav_msgs/OccupancyGrid",
  "nav_msgs/Odometry",
  "nav_msgs/Path",
  "sensor_msgs/Imu",
  "sensor_msgs/LaserScan",
  "sensor_msgs/PointCloud2",
  "sensor_msgs/Range",
  "visualization_msgs/Marker",
  "visualization_msgs/MarkerArray",
] as const;
export type DisplayType = (typeof DISPLAY_TYPES)[number];
