// Sends back each received message, at 115200 baud.
#include <ros.h>
#include <std_msgs/String.h>

ros::NodeHandle nh;

std_msgs::String text;
ros::Publisher out("out", &text);

void repeat(const std_msgs::String& heard) { out.publish(&heard); }
ros::Subscriber<std_msgs::String> in("in", &repeat);

void setup() {
  nh.getHardware()->setBaud(115200);
  nh.initNode();
  nh.advertise(out);
  nh.subscribe(in);
}

void loop() { nh.spinOnce(); }
