#ifndef TF_TF_H_
#define TF_TF_H_

#include "geometry_msgs/Quaternion.h"
#include <math.h>

namespace tf {

// The orientation after a rotation of `yaw` radians about the z axis.
inline geometry_msgs::Quaternion createQuaternionFromYaw(double yaw) {
  geometry_msgs::Quaternion q;
  q.z = sin(yaw * 0.5);
  q.w = cos(yaw * 0.5);
  return q;
}

// The orientation after rotations of roll, pitch and yaw, in radians, about the fixed axes x, y and z (REP 103).
inline geometry_msgs::Quaternion createQuaternionFromRPY(double roll, double pitch, double yaw) {
  const double cr = cos(roll * 0.5), sr = sin(roll * 0.5);
  const double cp = cos(pitch * 0.5), sp = sin(pitch * 0.5);
  const double cy = cos(yaw * 0.5), sy = sin(yaw * 0.5);
  geometry_msgs::Quaternion q;
  q.x = sr * cp * cy - cr * sp * sy;
  q.y = cr * sp * cy + sr * cp * sy;
  q.z = cr * cp * sy - sr * sp * cy;
  q.w = cr * cp * cy + sr * sp * sy;
  return q;
}

}  // namespace tf

#endif
