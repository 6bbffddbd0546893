// HelloWorld: a text, once a second, on the topic "chatter".
//
// Wiring: none, just the USB cable.
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /chatter

#include <ros.h>
#include <std_msgs/String.h>

ros::NodeHandle nh;

std_msgs::String text;
ros::Publisher chatter("chatter", &text);
unsigned long sent_ms;

void setup() {
  nh.initNode();
  nh.advertise(chatter);
}

void loop() {
  if (millis() - sent_ms >= 1000) {
    sent_ms = millis();
    text.data = "hello world!";
    chatter.publish(&text);
  }
  nh.spinOnce();  // communicates with the host; call it often
}
