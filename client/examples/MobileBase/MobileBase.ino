// MobileBase: the tasks of a TurtleBot3 Burger's board, for any robot with two driven wheels.
//
//   in   cmd_vel       geometry_msgs/Twist        speeds; without a new one, the robot stops after half a second
//        motor_power   std_msgs/Bool              false: the wheels stop
//        reset         std_msgs/Empty             makes the current place x = y = 0
//        sound         turtlebot3_msgs/Sound      a melody
//   out  odom, joint_states, tf                   the robot's position, ten times a second
//        imu, magnetic_field, sensor_state        ten times a second
//        battery_state, version_info              once a second
//
// Wiring:  a motor driver: left direction - pin 4, left PWM - 5, right PWM - 6, right direction - 7; a piezo buzzer
//          - 8; a bumper switch between 9 and GND; the battery's + through 20 kiloohm to A0, and A0 through 10 kiloohm
//          to GND; an MPU-9150 as in the example IMU. Missing parts are ignored.
// Try it:  rostether serve "/dev/ttyACM0?baud=250000"
//          rostether topic pub -r 10 /cmd_vel geometry_msgs/Twist "{linear: {x: 0.1}, angular: {z: 0.5}}"

#include <Wire.h>
#include <geometry_msgs/Twist.h>
#include <nav_msgs/Odometry.h>
#include <ros.h>
#include <ros/time.h>
#include <sensor_msgs/BatteryState.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/MagneticField.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Empty.h>
#include <tf/tf.h>
#include <tf/transform_broadcaster.h>
#include <turtlebot3_msgs/SensorState.h>
#include <turtlebot3_msgs/Sound.h>
#include <turtlebot3_msgs/VersionInfo.h>

#include "Drive.h"
#include "Mpu9150.h"

const int BUZZER = 8;
const int BUMPER = 9;
const int BATTERY = A0;
const float FULL_VOLTS = 12.4;   // three lithium cells
const float EMPTY_VOLTS = 11.0;

// Received messages are small: a Twist has 48 bytes. These sizes (subscribers, publishers, bytes in, bytes out) leave
// the memory of an Uno to the messages that are sent.
ros::NodeHandle_<ArduinoHardware, 4, 9, 128, 1024> nh;

// A publisher needs only the type. Messages are created when they are sent, one after the other in the
// same memory. All of them together would take 800 bytes, and an Uno has 2048.
template <class Message>
Message* only() {
  return NULL;
}

ros::Publisher pub_odom("odom", only<nav_msgs::Odometry>());
ros::Publisher pub_imu("imu", only<sensor_msgs::Imu>());
ros::Publisher pub_joints("joint_states", only<sensor_msgs::JointState>());
ros::Publisher pub_field("magnetic_field", only<sensor_msgs::MagneticField>());
ros::Publisher pub_battery("battery_state", only<sensor_msgs::BatteryState>());
ros::Publisher pub_state("sensor_state", only<turtlebot3_msgs::SensorState>());
ros::Publisher pub_version("version_info", only<turtlebot3_msgs::VersionInfo>());
tf::TransformBroadcaster broadcaster;

char left_name[] = "wheel_left_joint";
char right_name[] = "wheel_right_joint";
char* joint_names[] = {left_name, right_name};

Mpu9150 sensor;
bool has_sensor;
unsigned long driven_us;
unsigned long published_ms;
uint8_t rounds = 0;

void cmd_vel_cb(const geometry_msgs::Twist& twist) { command(twist.linear.x, twist.angular.z); }
void power_cb(const std_msgs::Bool& power) { has_power = power.data; }
void reset_cb(const std_msgs::Empty&) { resetOdometry(); }

void sound_cb(const turtlebot3_msgs::Sound& sound) {
  switch (sound.value) {
    case turtlebot3_msgs::Sound::OFF: tone(BUZZER, 262, 300); break;
    case turtlebot3_msgs::Sound::ON: tone(BUZZER, 523, 300); break;
    case turtlebot3_msgs::Sound::LOW_BATTERY: tone(BUZZER, 1000, 1000); break;
    case turtlebot3_msgs::Sound::ERROR: tone(BUZZER, 150, 1000); break;
    default: tone(BUZZER, 880, 100);
  }
}

ros::Subscriber<geometry_msgs::Twist> sub_cmd_vel("cmd_vel", &cmd_vel_cb);
ros::Subscriber<std_msgs::Bool> sub_power("motor_power", &power_cb);
ros::Subscriber<std_msgs::Empty> sub_reset("reset", &reset_cb);
ros::Subscriber<turtlebot3_msgs::Sound> sub_sound("sound", &sound_cb);

// Keeps the compiler from inlining the functions into one that needs memory for all messages at once.
#define APART __attribute__((noinline))

APART void publishOdometry(const ros::Time& stamp) {
  nav_msgs::Odometry odom;
  odom.header.stamp = stamp;
  odom.header.frame_id = "odom";
  odom.child_frame_id = "base_footprint";
  odom.pose.pose.position.x = x;
  odom.pose.pose.position.y = y;
  odom.pose.pose.orientation = tf::createQuaternionFromYaw(heading);
  odom.twist.twist.linear.x = speed;
  odom.twist.twist.angular.z = turn_rate;
  pub_odom.publish(&odom);
}

APART void publishTransform(const ros::Time& stamp) {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = stamp;
  transform.header.frame_id = "odom";
  transform.child_frame_id = "base_footprint";
  transform.transform.translation.x = x;
  transform.transform.translation.y = y;
  transform.transform.rotation = tf::createQuaternionFromYaw(heading);
  broadcaster.sendTransform(transform);
}

APART void publishJoints(const ros::Time& stamp) {
  float angles[] = {left.angle, right.angle};
  float speeds[] = {left.speed, right.speed};
  sensor_msgs::JointState joints;
  joints.header.stamp = stamp;
  joints.header.frame_id = "base_link";
  joints.name = joint_names;
  joints.position = angles;
  joints.velocity = speeds;
  joints.name_length = joints.position_length = joints.velocity_length = 2;
  pub_joints.publish(&joints);
}

APART void publishImu(const ros::Time& stamp) {
  sensor_msgs::Imu imu;
  imu.header.stamp = stamp;
  imu.header.frame_id = "imu_link";
  imu.orientation = tf::createQuaternionFromYaw(heading);
  imu.angular_velocity.x = sensor.angular_velocity.x;
  imu.angular_velocity.y = sensor.angular_velocity.y;
  imu.angular_velocity.z = sensor.angular_velocity.z;
  imu.linear_acceleration.x = sensor.acceleration.x;
  imu.linear_acceleration.y = sensor.acceleration.y;
  imu.linear_acceleration.z = sensor.acceleration.z;
  pub_imu.publish(&imu);
}

APART void publishField(const ros::Time& stamp) {
  sensor_msgs::MagneticField field;
  field.header.stamp = stamp;
  field.header.frame_id = "imu_link";
  field.magnetic_field.x = sensor.magnetic_field.x;
  field.magnetic_field.y = sensor.magnetic_field.y;
  field.magnetic_field.z = sensor.magnetic_field.z;
  pub_field.publish(&field);
}

float batteryVolts() {
  return analogRead(BATTERY) * (3 * 5.0 / 1024);  // the resistors divide the voltage by three
}

APART void publishState(const ros::Time& stamp) {
  turtlebot3_msgs::SensorState state;
  state.header.stamp = stamp;
  state.bumper = digitalRead(BUMPER) == LOW ? turtlebot3_msgs::SensorState::BUMPER_FORWARD : 0;
  state.torque = has_power;
  state.left_encoder = left.ticks;
  state.right_encoder = right.ticks;
  state.battery = batteryVolts();
  pub_state.publish(&state);
}

APART void publishBattery(const ros::Time& stamp) {
  sensor_msgs::BatteryState battery;
  battery.header.stamp = stamp;
  battery.voltage = batteryVolts();
  battery.percentage = constrain((battery.voltage - EMPTY_VOLTS) / (FULL_VOLTS - EMPTY_VOLTS), 0.0, 1.0);
  battery.current = battery.charge = battery.capacity = NAN;  // not measured
  battery.design_capacity = 1.8;                              // Ah
  battery.present = battery.voltage > 5;
  pub_battery.publish(&battery);
}

APART void publishVersion() {
  turtlebot3_msgs::VersionInfo version;
  version.hardware = "Arduino";
  version.firmware = "1.0";
  version.software = "1.0";
  pub_version.publish(&version);
}

void setup() {
  beginDrive();
  pinMode(BUMPER, INPUT_PULLUP);
  has_sensor = sensor.begin();

  nh.getHardware()->setBaud(250000);
  nh.initNode();
  nh.advertise(pub_odom);
  nh.advertise(pub_imu);
  nh.advertise(pub_joints);
  nh.advertise(pub_field);
  nh.advertise(pub_battery);
  nh.advertise(pub_state);
  nh.advertise(pub_version);
  broadcaster.init(nh);
  nh.subscribe(sub_cmd_vel);
  nh.subscribe(sub_power);
  nh.subscribe(sub_reset);
  nh.subscribe(sub_sound);
  driven_us = micros();
}

void loop() {
  nh.spinOnce();
  const unsigned long now_us = micros();
  if (now_us - driven_us >= 20000) {
    drive((now_us - driven_us) * 1e-6);
    driven_us = now_us;
  }
  if (millis() - published_ms < 100) return;
  published_ms = millis();

  const ros::Time stamp = nh.now();
  publishOdometry(stamp);
  nh.spinOnce();  // a round of messages takes 60 ms: commands should not wait that long
  publishTransform(stamp);
  publishJoints(stamp);
  publishState(stamp);
  if (has_sensor) {
    sensor.measure();
    publishImu(stamp);
    nh.spinOnce();
    publishField(stamp);
  }
  if (++rounds < 10) return;
  rounds = 0;
  publishBattery(stamp);
  publishVersion();
}
