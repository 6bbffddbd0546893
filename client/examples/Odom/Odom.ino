// Odom: a simulated robot that drives in a circle. Publishes its pose as the transform odom -> base_link.
//
// Wiring: none. A real robot would read its speed and turn rate from the encoders of its wheels.
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /tf

#include <ros.h>
#include <ros/time.h>
#include <tf/tf.h>
#include <tf/transform_broadcaster.h>

ros::NodeHandle nh;

geometry_msgs::TransformStamped transform;
tf::TransformBroadcaster broadcaster;

const float FORWARD_SPEED = 0.2;       // m/s
const float TURN_RATE = 0.36;  // rad/s: a circle of 0.2 / 0.36 = 0.56 m radius, around in 17.5 s

float x = 0.0;
float y = 0.0;
float heading = 0.0;
unsigned long last_ms;

void setup() {
  nh.initNode();
  broadcaster.init(nh);
  transform.header.frame_id = "odom";
  transform.child_frame_id = "base_link";
}

void loop() {
  const unsigned long now_ms = millis();
  const float dt = (now_ms - last_ms) * 0.001;
  last_ms = now_ms;

  // Each step is a straight line, in the direction at the middle of the step.
  const float halfway = heading + 0.5 * TURN_RATE * dt;
  x += FORWARD_SPEED * dt * cos(halfway);
  y += FORWARD_SPEED * dt * sin(halfway);
  heading += TURN_RATE * dt;
  if (heading > PI) heading -= TWO_PI;

  transform.header.stamp = nh.now();
  transform.transform.translation.x = x;
  transform.transform.translation.y = y;
  transform.transform.rotation = tf::createQuaternionFromYaw(heading);
  broadcaster.sendTransform(transform);

  nh.spinOnce();
  delay(50);
}
