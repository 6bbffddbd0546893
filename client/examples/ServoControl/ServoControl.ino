// ServoControl: turns a hobby servo to the angle, in degrees from 0 to 180, that it receives on the topic "servo".
//
// Wiring:  servo red - 5V (a separate supply for more than one small servo), brown - GND, orange - pin 9.
// Try it:  rostether serve /dev/ttyACM0          rostether topic pub -1 /servo std_msgs/UInt16 45

#include <Servo.h>
#include <ros.h>
#include <std_msgs/UInt16.h>

ros::NodeHandle nh;

const int LED = 13;
Servo servo;

void servo_cb(const std_msgs::UInt16& angle) {
  servo.write(angle.data);
  digitalWrite(LED, HIGH - digitalRead(LED));  // changes with every message
}

ros::Subscriber<std_msgs::UInt16> sub("servo", servo_cb);

void setup() {
  pinMode(LED, OUTPUT);
  nh.initNode();
  nh.subscribe(sub);
  servo.attach(9);
}

void loop() {
  nh.spinOnce();
  delay(1);
}
