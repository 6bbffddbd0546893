// The fields of message types that the 3D view reads, as the decoder gives them.
import type { Stamp } from "../wire/stamp.ts";

export interface Header {
  stamp: Stamp;
  frame_id: string;
}
export interface Xyz {
  x: number;
  y: number;
  z: number;
}
export interface Xyzw extends Xyz {
  w: number;
}
export interface Rgba {
  r: number;
  g: number;
  b: number;
  a: number;
}
export interface Pose {
  position: Xyz;
  orientation: Xyzw;
}
export interface TransformStamped {
  header: Header;
  child_frame_id: string;
  transform: { translation: Xyz; rotation: Xyzw };
}
/** sensor_msgs/LaserScan */
export interface LaserScan {
  header: Header;
  angle_min: number;
  angle_increment: number;
  range_min: number;
  range_max: number;
  ranges: ArrayLike<number>;
  intensities: ArrayLike<number>;
}
/** sensor_msgs/Range */
export interface Range {
  header: Header;
  radiation_type: number;
  field_of_view: number;
  min_range: number;
  max_range: number;
  range: number;
}
/** sensor_msgs/Imu */
export interface Imu {
  header: Header;
  orientation: Xyzw;
  orientation_covariance: ArrayLike<number>;
  linear_acceleration: Xyz;
}
/** sensor_msgs/PointField */
export interface PointField {
  name: string;
  offset: number;
  datatype: number;
  count: number;
}
/** sensor_msgs/PointCloud2 */
export interface PointCloud2 {
  header: Header;
  height: number;
  width: number;
  fields: PointField[];
  is_bigendian: boolean;
  point_step: number;
  row_step: number;
  data: Uint8Array;
}
/** nav_msgs/OccupancyGrid */
export interface OccupancyGrid {
  header: Header;
  info: { resolution: number; width: number; height: number; origin: Pose };
  data: Int8Array;
}
/** visualization_msgs/Marker */
export interface Marker {
  header: Header;
  ns: string;
  id: number;
  type: number;
  action: number;
  pose: Pose;
  scale: Xyz;
  color: Rgba;
  lifetime: Stamp;
  frame_locked: boolean;
  points: Xyz[];
  colors: Rgba[];
  text: string;
  mesh_resource: string;
}
