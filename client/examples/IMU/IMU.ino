// IMU: the orientation of an MPU-9150, on the topic "imu_data" and as the transform base_link -> imu_link.
//
// Wiring:  sensor VCC - 3.3V, GND - GND, SDA - A4, SCL - A5 (on a Mega SDA - 20, SCL - 21).
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /imu_data          rviz, fixed frame base_link
//
// A gyroscope follows every movement, but drifts. Gravity and the Earth's magnetic field show the true attitude, but
// every movement disturbs their measurement. A complementary filter combines the fast changes of the gyroscope with
// the slow changes of gravity and field.
// Roll, pitch and yaw are zero when the sensor lies flat and its x axis points to magnetic north.

#include <Wire.h>
#include <ros.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <tf/transform_broadcaster.h>

#include "Mpu9150.h"

const float MEMORY_S = 0.5;           // after this time, gravity and field count more than the gyroscope
const unsigned long PERIOD_MS = 100;  // at 57600 baud, one round of messages takes 80 ms

ros::NodeHandle nh;

sensor_msgs::Imu imu;
ros::Publisher pub_imu("imu_data", &imu);
geometry_msgs::TransformStamped transform;
tf::TransformBroadcaster broadcaster;

Mpu9150 sensor;
bool has_sensor;
geometry_msgs::Quaternion attitude;
unsigned long measured_us;
unsigned long published_ms;

geometry_msgs::Quaternion multiply(const geometry_msgs::Quaternion& a, const geometry_msgs::Quaternion& b) {
  geometry_msgs::Quaternion product;
  product.w = a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z;
  product.x = a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y;
  product.y = a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x;
  product.z = a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w;
  return product;
}

geometry_msgs::Quaternion turnAbout(float x, float y, float z, float angle) {
  const float s = sin(angle / 2);
  geometry_msgs::Quaternion turn;
  turn.x = s * x;
  turn.y = s * y;
  turn.z = s * z;
  turn.w = cos(angle / 2);
  return turn;
}

// Computes the attitude from gravity and the magnetic field.
geometry_msgs::Quaternion trueAttitude() {
  const Vector3& a = sensor.acceleration;
  const Vector3& m = sensor.magnetic_field;
  const float roll = atan2(a.y, a.z);
  const float sr = sin(roll), cr = cos(roll);
  const float up = a.y * sr + a.z * cr;
  const float pitch = atan2(-a.x, up);
  const float sp = sin(pitch), cp = cos(pitch);
  // The horizontal components of the field: a compass that corrects the tilt of the sensor.
  const float north = m.x * cp + (m.y * sr + m.z * cr) * sp;
  const float west = m.y * cr - m.z * sr;
  const float yaw = atan2(-west, north);
  return multiply(turnAbout(0, 0, 1, yaw), multiply(turnAbout(0, 1, 0, pitch), turnAbout(1, 0, 0, roll)));
}

void follow(float dt) {
  const Vector3& rate = sensor.angular_velocity;
  geometry_msgs::Quaternion turn;
  turn.w = 1;
  turn.x = rate.x * dt / 2;
  turn.y = rate.y * dt / 2;
  turn.z = rate.z * dt / 2;
  const geometry_msgs::Quaternion guess = multiply(attitude, turn);
  const geometry_msgs::Quaternion truth = trueAttitude();

  // q and -q are the same attitude; choose the nearer one.
  const float near = guess.w * truth.w + guess.x * truth.x + guess.y * truth.y + guess.z * truth.z;
  const float trust = dt / (MEMORY_S + dt);
  const float t = near < 0 ? -trust : trust;
  attitude.w = (1 - trust) * guess.w + t * truth.w;
  attitude.x = (1 - trust) * guess.x + t * truth.x;
  attitude.y = (1 - trust) * guess.y + t * truth.y;
  attitude.z = (1 - trust) * guess.z + t * truth.z;
  const float length = sqrt(attitude.w * attitude.w + attitude.x * attitude.x + attitude.y * attitude.y +
                            attitude.z * attitude.z);
  attitude.w /= length;
  attitude.x /= length;
  attitude.y /= length;
  attitude.z /= length;
}

template <class Number>
void setDiagonal(Number* covariance, float variance) {
  covariance[0] = covariance[4] = covariance[8] = variance;
}

void setup() {
  nh.initNode();
  nh.advertise(pub_imu);
  broadcaster.init(nh);

  imu.header.frame_id = "imu_link";
  setDiagonal(imu.orientation_covariance, 0.0012);        // the square of 2 degrees in rad
  setDiagonal(imu.angular_velocity_covariance, 1e-5);     // 0.2 degrees a second
  setDiagonal(imu.linear_acceleration_covariance, 0.01);  // 0.1 m/s^2

  transform.header.frame_id = "base_link";
  transform.child_frame_id = "imu_link";
  transform.transform.translation.x = 1.0;  // meters: with this distance, both frames are visible in rviz

  has_sensor = sensor.begin();
  sensor.measure();
  attitude = trueAttitude();
  measured_us = micros();
}

void loop() {
  nh.spinOnce();
  if (has_sensor) {
    sensor.measure();
    const unsigned long now_us = micros();
    follow((now_us - measured_us) * 1e-6);
    measured_us = now_us;
  }
  if (millis() - published_ms < PERIOD_MS) return;
  published_ms = millis();

  if (!has_sensor) {
    nh.logerror("no MPU-9150 answers on I2C");
    delay(1000);
    return;
  }
  imu.header.stamp = nh.now();
  imu.orientation = attitude;
  imu.angular_velocity.x = sensor.angular_velocity.x;
  imu.angular_velocity.y = sensor.angular_velocity.y;
  imu.angular_velocity.z = sensor.angular_velocity.z;
  imu.linear_acceleration.x = sensor.acceleration.x;
  imu.linear_acceleration.y = sensor.acceleration.y;
  imu.linear_acceleration.z = sensor.acceleration.z;
  pub_imu.publish(&imu);

  transform.header.stamp = imu.header.stamp;
  transform.transform.rotation = attitude;
  broadcaster.sendTransform(transform);
}
