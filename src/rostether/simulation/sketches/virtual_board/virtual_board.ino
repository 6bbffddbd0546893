// virtual_board: the board of `rostether demo`, with an HC-SR04 and an LED. Its odometry is a circle.
//
// Wiring:  LED - pin 13; HC-SR04 VCC - 5V, GND - GND, Trig - pin 6, Echo - pin 5.
// Topics:  ultrasound, led, count and /tf out; toggle_led in. Service: set_led. Parameter: ~blink_hz.

#include <ros.h>
#include <ros/time.h>
#include <sensor_msgs/Range.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Empty.h>
#include <std_msgs/UInt32.h>
#include <std_srvs/SetBool.h>
#include <tf/tfMessage.h>

using std_srvs::SetBool;

const int LED = 13;
const int TRIG = 6;
const int ECHO = 5;

const unsigned long BAUD = 115200;
const unsigned long PERIOD_MS = 50;           // of the sensor and of /tf
const unsigned long SLOW_PERIOD_MS = 1000;    // of led and count
const unsigned long LONGEST_ECHO_US = 25000;  // there and back over 4 m
const float SPEED_OF_SOUND = 343.0e-6;        // meters in a microsecond, at 20 degrees Celsius
const float LAP_S = 20.0;                     // for a circle of 1 m radius
const int MAX_BLINK_HZ = 50;

ros::NodeHandle nh;

std_msgs::Bool led_msg;
ros::Publisher pub_led("led", &led_msg);
sensor_msgs::Range range_msg;
ros::Publisher pub_range("ultrasound", &range_msg);
std_msgs::UInt32 count_msg;
ros::Publisher pub_count("count", &count_msg);
geometry_msgs::TransformStamped frames[2];
geometry_msgs::TransformStamped& robot = frames[0];
geometry_msgs::TransformStamped& sensor = frames[1];
tf::tfMessage tf_msg;
ros::Publisher pub_tf("/tf", &tf_msg);

unsigned long measured_ms, slow_ms, blinked_ms;
unsigned long blink_period_ms = 0;  // from one change of the LED to the next; 0: no blinking
bool was_connected = false;

void setLed(bool on) {
  led_msg.data = on;
  digitalWrite(LED, on);
  pub_led.publish(&led_msg);
}

void toggleLed(const std_msgs::Empty&) {
  setLed(!led_msg.data);
  nh.loginfo(led_msg.data ? "LED on" : "LED off");
}

void serveSetLed(const SetBool::Request& request, SetBool::Response& response) {
  setLed(request.data);
  response.success = true;
  response.message = request.data ? "LED on" : "LED off";
}

ros::Subscriber<std_msgs::Empty> sub_toggle("toggle_led", &toggleLed);
ros::ServiceServer<SetBool::Request, SetBool::Response> set_led("set_led", &serveSetLed);

// Returns the time at which the echo pin leaves a level; 0 if it does not.
unsigned long endOf(int level) {
  const unsigned long began_us = micros();
  while (digitalRead(ECHO) == level) {
    if (micros() - began_us > LONGEST_ECHO_US) return 0;
  }
  return micros();
}

// Returns meters; infinity if there is no echo.
float measureRange() {
  digitalWrite(TRIG, HIGH);  // a pulse of ten microseconds starts the measurement
  delayMicroseconds(10);
  digitalWrite(TRIG, LOW);
  const unsigned long sent_us = endOf(LOW);
  const unsigned long back_us = endOf(HIGH);
  if (sent_us == 0 || back_us == 0) return INFINITY;
  return (back_us - sent_us) * (SPEED_OF_SOUND / 2);  // the sound goes there and back
}

void publishRange() {
  range_msg.range = measureRange();
  range_msg.header.stamp = nh.now();
  pub_range.publish(&range_msg);
}

void publishPose() {
  const float yaw = fmod(millis() / 1000.0 / LAP_S, 1.0) * 2 * PI;
  robot.header.stamp = sensor.header.stamp = range_msg.header.stamp;
  robot.transform.translation.x = sin(yaw);
  robot.transform.translation.y = 1 - cos(yaw);
  robot.transform.rotation.z = sin(yaw / 2);
  robot.transform.rotation.w = cos(yaw / 2);
  pub_tf.publish(&tf_msg);
}

void readParameters() {
  int blink_hz = 0;
  nh.getParam("~blink_hz", &blink_hz);
  const bool blinks = blink_hz > 0 && blink_hz <= MAX_BLINK_HZ;
  blink_period_ms = blinks ? 500 / blink_hz : 0;
}

void setup() {
  pinMode(LED, OUTPUT);
  pinMode(TRIG, OUTPUT);
  pinMode(ECHO, INPUT);

  range_msg.header.frame_id = "ultrasound";
  range_msg.radiation_type = sensor_msgs::Range::ULTRASOUND;
  range_msg.field_of_view = 0.26;  // radians: 15 degrees
  range_msg.min_range = 0.02;
  range_msg.max_range = 4.0;
  robot.header.frame_id = "odom";
  robot.child_frame_id = sensor.header.frame_id = "base_link";
  sensor.child_frame_id = "ultrasound";
  sensor.transform.translation.x = 0.1;
  sensor.transform.translation.z = 0.05;
  sensor.transform.rotation.w = 1;
  tf_msg.transforms = frames;
  tf_msg.transforms_length = 2;

  nh.getHardware()->setBaud(BAUD);
  nh.initNode();
  nh.advertise(pub_led);
  nh.advertise(pub_range);
  nh.advertise(pub_count);
  nh.advertise(pub_tf);
  nh.subscribe(sub_toggle);
  nh.advertiseService(set_led);
}

void loop() {
  nh.spinOnce();
  if (nh.connected() && !was_connected) {
    nh.loginfo("virtual board ready");
    readParameters();
  }
  was_connected = nh.connected();

  const unsigned long now_ms = millis();
  if (now_ms - measured_ms >= PERIOD_MS) {
    measured_ms = now_ms;
    publishRange();
    publishPose();
  }
  if (now_ms - slow_ms >= SLOW_PERIOD_MS) {
    slow_ms = now_ms;
    pub_led.publish(&led_msg);
    pub_count.publish(&count_msg);
    count_msg.data++;
  }
  if (blink_period_ms > 0 && now_ms - blinked_ms >= blink_period_ms) {
    blinked_ms = now_ms;
    setLed(!led_msg.data);
  }
}
