// The robot's roll, pitch and yaw: the gyroscope shows each movement, and gravity corrects roll and pitch.
#ifndef ATTITUDE_H
#define ATTITUDE_H

#include <Arduino.h>
#include <geometry_msgs/Quaternion.h>

#include "Mpu9250.h"

class Attitude {
 public:
  float roll = 0, pitch = 0, yaw = 0;  // rad; the yaw is 0 at the start, and drifts

  void follow(const Mpu9250& sensor, float dt) {
    const Vector3& rate = sensor.angular_velocity;
    const Vector3& a = sensor.acceleration;
    const float sr = sin(roll), cr = cos(roll), tp = tan(pitch);
    const float down = rate.y * sr + rate.z * cr;
    roll += (rate.x + down * tp) * dt;
    yaw += down / cos(pitch) * dt;
    pitch += (rate.y * cr - rate.z * sr) * dt;
    if (yaw > PI) yaw -= TWO_PI;
    if (yaw < -PI) yaw += TWO_PI;
    // While the robot speeds up, the sensor measures more than gravity.
    const float trust = dt / (MEMORY_S + dt);
    roll += trust * (atan2(a.y, a.z) - roll);
    pitch += trust * (atan2(-a.x, sqrt(a.y * a.y + a.z * a.z)) - pitch);
  }

  geometry_msgs::Quaternion quaternion() const {
    const float cr = cos(roll / 2), sr = sin(roll / 2);
    const float cp = cos(pitch / 2), sp = sin(pitch / 2);
    const float cy = cos(yaw / 2), sy = sin(yaw / 2);
    geometry_msgs::Quaternion q;
    q.w = cr * cp * cy + sr * sp * sy;
    q.x = sr * cp * cy - cr * sp * sy;
    q.y = cr * sp * cy + sr * cp * sy;
    q.z = cr * cp * sy - sr * sp * cy;
    return q;
  }

 private:
  static constexpr float MEMORY_S = 1;
};

#endif
