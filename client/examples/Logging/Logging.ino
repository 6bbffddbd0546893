// Logging: texts in the host's log (/rosout). There are five levels; this sketch uses each in turn.
//
// Wiring: none.
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /rosout

#include <ros.h>
#include <std_msgs/String.h>

ros::NodeHandle nh;

std_msgs::String text;
ros::Publisher chatter("chatter", &text);

void setup() {
  nh.initNode();
  nh.advertise(chatter);
}

void loop() {
  text.data = "hello world!";
  chatter.publish(&text);

  nh.logdebug("a detail");
  nh.loginfo("all is well");
  nh.logwarn("unusual");
  nh.logerror("broken");
  nh.logfatal("nothing works");

  nh.spinOnce();
  delay(500);
}
