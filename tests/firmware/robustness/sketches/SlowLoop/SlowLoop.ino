// Sleeps in loop(), so that several topic requests wait when it spins.
#include <ros.h>
#include <std_msgs/UInt16.h>

ros::NodeHandle nh;

#ifndef LOOP_MS
#define LOOP_MS 1000
#endif
uint16_t settings_heard = 0;

void hear(const std_msgs::UInt16&) { ++settings_heard; }
ros::Subscriber<std_msgs::UInt16> setting("setting", &hear);

void setup() {
  nh.initNode();
  nh.subscribe(setting);
}

void loop() {
  nh.spinOnce();
  delay(LOOP_MS);
}
