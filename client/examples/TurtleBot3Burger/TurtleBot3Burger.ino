// TurtleBot3Burger: the firmware for the board of a TurtleBot3 Burger, an OpenCR.
//
//   in   cmd_vel        geometry_msgs/Twist                speeds; without a new one, it stops after half a second
//        motor_power    std_msgs/Bool                      false: the wheels turn freely
//        reset          std_msgs/Empty                     makes the current place x = y = 0; at rest, also
//                                                          calibrates the gyroscope
//        sound          turtlebot3_msgs/Sound              a melody
//   out  imu, magnetic_field                               200 times a second
//        odom, joint_states, tf, sensor_state,
//        battery_state, cmd_vel_rc100                      30 times a second
//        version_info, firmware_version, diagnostics       once a second
//
// The parameter ~tf_prefix is put before the names of frames: for several robots in one graph.
//
// Wiring:  as ROBOTIS delivers the robot: the servos XL430 (left 1, right 2, 1 Mbaud) at the connectors TTL, the
//          battery, and the USB port to the computer. Optional: sonar HC-SR04 at GPIO 1 (trigger) and 2 (echo); OLLO
//          infrared sensor at 2 and touch sensors at 3 (back) and 4 (front); light sensor at A1; receiver of the
//          remote control RC-100 at UART2.
// Try it:  rostether serve "/dev/ttyACM0?baud=115200"
//          rostether topic pub -r 10 /cmd_vel geometry_msgs/Twist "{linear: {x: 0.1}, angular: {z: 0.5}}"

#include <diagnostic_msgs/DiagnosticArray.h>
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
#include <stdio.h>
#include <tf/tf.h>
#include <tf/transform_broadcaster.h>
#include <turtlebot3_msgs/SensorState.h>
#include <turtlebot3_msgs/Sound.h>
#include <turtlebot3_msgs/VersionInfo.h>

#include "Attitude.h"
#include "Melody.h"
#include "Mpu9250.h"
#include "Remote.h"
#include "Report.h"
#include "Sensors.h"
#include "Wheels.h"

// The sizes are: subscribers, publishers, bytes in, bytes out.
ros::NodeHandle_<ArduinoHardware, 4, 12, 512, 1024> nh;

nav_msgs::Odometry odom;
sensor_msgs::Imu imu;
sensor_msgs::MagneticField field;
sensor_msgs::JointState joints;
sensor_msgs::BatteryState battery;
turtlebot3_msgs::SensorState state;
turtlebot3_msgs::VersionInfo version;
geometry_msgs::Twist remote_twist;
geometry_msgs::TransformStamped transform;
diagnostic_msgs::DiagnosticArray diagnostics;

ros::Publisher pub_odom("odom", &odom);
ros::Publisher pub_imu("imu", &imu);
ros::Publisher pub_field("magnetic_field", &field);
ros::Publisher pub_joints("joint_states", &joints);
ros::Publisher pub_battery("battery_state", &battery);
ros::Publisher pub_state("sensor_state", &state);
ros::Publisher pub_remote("cmd_vel_rc100", &remote_twist);
ros::Publisher pub_version("version_info", &version);
ros::Publisher pub_firmware("firmware_version", &version);
ros::Publisher pub_diagnostics("diagnostics", &diagnostics);
tf::TransformBroadcaster broadcaster;

Wheels wheels;
Mpu9250 sensor;
Attitude attitude;
Sensors sensors;
Melody melody;
Remote remote;
Report report;

bool has_imu;
bool was_connected;
float forward, turn;  // commanded: m/s, rad/s
uint32_t commanded_ms, remote_ms;
uint32_t measured_us;
uint8_t rounds;

// The names of the frames, with the prefix.
struct Frames {
  char odom[48], base_footprint[48], base_link[48], imu_link[48], mag_link[48];
} frames;

// A task that is due `hertz` times a second. A loop that is late skips the times that it has missed.
class Rate {
 public:
  explicit Rate(uint32_t hertz) : period_us_(1000000 / hertz), last_us_(0) {}
  bool isDue() {
    const uint32_t late_us = micros() - last_us_;
    if (late_us < period_us_) return false;
    last_us_ += late_us - late_us % period_us_;
    return true;
  }

 private:
  const uint32_t period_us_;
  uint32_t last_us_;
};

Rate imu_rate(200), drive_rate(30), sonar_rate(10), slow_rate(1);

void cmd_vel_cb(const geometry_msgs::Twist& twist) {
  forward = twist.linear.x;
  turn = twist.angular.z;
  commanded_ms = millis();
}
void power_cb(const std_msgs::Bool& power) { wheels.setTorque(power.data); }
void reset_cb(const std_msgs::Empty&) {
  wheels.resetOdometry();
  attitude.yaw = 0;
  if (wheels.speed == 0 && wheels.turn_rate == 0) sensor.calibrate();
  nh.loginfo("reset odometry");
}
void sound_cb(const turtlebot3_msgs::Sound& sound) { melody.play(sound.value); }

ros::Subscriber<geometry_msgs::Twist> sub_cmd_vel("cmd_vel", &cmd_vel_cb);
ros::Subscriber<std_msgs::Bool> sub_power("motor_power", &power_cb);
ros::Subscriber<std_msgs::Empty> sub_reset("reset", &reset_cb);
ros::Subscriber<turtlebot3_msgs::Sound> sub_sound("sound", &sound_cb);

void setFrame(char (&frame)[48], const char* prefix, const char* name) {
  snprintf(frame, sizeof frame, "%s%s%s", prefix, *prefix ? "/" : "", name);
}

void setFrames() {
  char prefix[32] = "";
  nh.getParam("~tf_prefix", prefix, sizeof prefix);
  setFrame(frames.odom, prefix, "odom");
  setFrame(frames.base_footprint, prefix, "base_footprint");
  setFrame(frames.base_link, prefix, "base_link");
  setFrame(frames.imu_link, prefix, "imu_link");
  setFrame(frames.mag_link, prefix, "mag_link");
}

template <class Number>
void setDiagonal(Number* covariance, float variance) {
  covariance[0] = covariance[4] = covariance[8] = variance;
}

// Fills in the constant parts of the messages.
void fillMessages() {
  odom.header.frame_id = transform.header.frame_id = frames.odom;
  odom.child_frame_id = transform.child_frame_id = frames.base_footprint;
  imu.header.frame_id = frames.imu_link;
  setDiagonal(imu.orientation_covariance, 0.0025);
  setDiagonal(imu.angular_velocity_covariance, 0.02);
  setDiagonal(imu.linear_acceleration_covariance, 0.04);
  field.header.frame_id = frames.mag_link;
  setDiagonal(field.magnetic_field_covariance, 0.0048);
  static const char* names[] = {"wheel_left_joint", "wheel_right_joint"};
  joints.header.frame_id = frames.base_link;
  joints.name = const_cast<char**>(names);
  joints.name_length = joints.position_length = joints.velocity_length = 2;
  battery.current = battery.charge = battery.capacity = NAN;  // not measured
  battery.design_capacity = 1.8;                              // Ah
  version.hardware = "OpenCR";
  version.firmware = "1.2.6";  // of ROBOTIS' firmware with these topics: turtlebot3_bringup checks it
  version.software = "rostether";
}

void publishImu(const ros::Time& stamp) {
  imu.header.stamp = field.header.stamp = stamp;
  imu.orientation = attitude.quaternion();
  imu.angular_velocity.x = sensor.angular_velocity.x;
  imu.angular_velocity.y = sensor.angular_velocity.y;
  imu.angular_velocity.z = sensor.angular_velocity.z;
  imu.linear_acceleration.x = sensor.acceleration.x;
  imu.linear_acceleration.y = sensor.acceleration.y;
  imu.linear_acceleration.z = sensor.acceleration.z;
  pub_imu.publish(&imu);
  field.magnetic_field.x = sensor.magnetic_field.x;
  field.magnetic_field.y = sensor.magnetic_field.y;
  field.magnetic_field.z = sensor.magnetic_field.z;
  pub_field.publish(&field);
}

void measureImu() {
  sensor.measure();
  const uint32_t now_us = micros();
  attitude.follow(sensor, (now_us - measured_us) * 1e-6f);
  measured_us = now_us;
  publishImu(nh.now());
}

// The heading is that of the wheels. The heading of the gyroscope, which does not slip, is in `imu`.
void publishOdometry(const ros::Time& stamp) {
  odom.header.stamp = transform.header.stamp = stamp;
  odom.pose.pose.position.x = transform.transform.translation.x = wheels.x;
  odom.pose.pose.position.y = transform.transform.translation.y = wheels.y;
  odom.pose.pose.orientation = transform.transform.rotation = tf::createQuaternionFromYaw(wheels.heading);
  odom.twist.twist.linear.x = wheels.speed;
  odom.twist.twist.angular.z = wheels.turn_rate;
  pub_odom.publish(&odom);
  broadcaster.sendTransform(transform);
}

void publishJoints(const ros::Time& stamp) {
  float angles[] = {wheels.left.angle, wheels.right.angle};
  float speeds[] = {wheels.left.speed, wheels.right.speed};
  joints.header.stamp = stamp;
  joints.position = angles;
  joints.velocity = speeds;
  pub_joints.publish(&joints);
}

void publishState(const ros::Time& stamp) {
  state.header.stamp = battery.header.stamp = stamp;
  state.bumper = sensors.bumper();
  state.cliff = sensors.cliff();
  state.sonar = sensors.sonar;
  state.illumination = sensors.illumination();
  state.led = sensors.lit();
  state.button = sensors.buttons();
  state.torque = wheels.hasTorque();
  state.left_encoder = wheels.left.ticks;
  state.right_encoder = wheels.right.ticks;
  state.battery = battery.voltage = sensors.batteryVolts();
  pub_state.publish(&state);
  battery.percentage = sensors.batteryPart();
  battery.present = battery.voltage > 5;
  pub_battery.publish(&battery);
}

void publishSlowly(const ros::Time& stamp) {
  pub_version.publish(&version);
  pub_firmware.publish(&version);
  report.header().stamp = stamp;
  pub_diagnostics.publish(&report.make(wheels, sensors, has_imu));
}

void drive() {
  // Each has its own time limit: commands from the computer must not extend those of a lost remote control,
  // nor the reverse.
  if (remote.update()) remote_ms = millis();
  if (millis() - commanded_ms > COMMAND_LIFE_MS) forward = turn = 0;
  if (millis() - remote_ms > COMMAND_LIFE_MS) remote.forward = remote.turn = 0;
  wheels.drive(forward + remote.forward, turn + remote.turn);
  remote_twist.linear.x = remote.forward;
  remote_twist.angular.z = remote.turn;
}

// USER1 lights while the host is connected, USER2 if the battery is low, USER3 without torque. USER4 blinks.
void showLights() {
  const bool is_low = sensors.batteryVolts() < EMPTY_VOLTS;
  sensors.show((nh.connected() ? 1 : 0) | (is_low ? 2 : 0) | (wheels.hasTorque() ? 0 : 4) | (rounds & 16 ? 8 : 0));
}

void setup() {
  sensors.begin();
  remote.begin();
  has_imu = sensor.begin();
  nh.getHardware()->setBaud(115200);
  nh.initNode();
  nh.advertise(pub_odom);
  nh.advertise(pub_imu);
  nh.advertise(pub_field);
  nh.advertise(pub_joints);
  nh.advertise(pub_battery);
  nh.advertise(pub_state);
  nh.advertise(pub_remote);
  nh.advertise(pub_version);
  nh.advertise(pub_firmware);
  nh.advertise(pub_diagnostics);
  broadcaster.init(nh);
  nh.subscribe(sub_cmd_vel);
  nh.subscribe(sub_power);
  nh.subscribe(sub_reset);
  nh.subscribe(sub_sound);
  fillMessages();
  wheels.begin();
  measured_us = micros();
}

void loop() {
  nh.spinOnce();
  if (nh.connected() != was_connected) {
    was_connected = nh.connected();
    if (was_connected) setFrames();
  }
  melody.update();
  if (imu_rate.isDue()) {
    if (has_imu) measureImu();
    if (sonar_rate.isDue()) sensors.measureSonar();
  }
  if (drive_rate.isDue()) {
    ++rounds;
    drive();
    const bool has_measured = wheels.measure();
    const ros::Time stamp = nh.now();
    if (has_measured) {
      publishOdometry(stamp);
      publishJoints(stamp);
    }
    publishState(stamp);
    pub_remote.publish(&remote_twist);
    showLights();
  }
  if (slow_rate.isDue()) publishSlowly(nh.now());
}
