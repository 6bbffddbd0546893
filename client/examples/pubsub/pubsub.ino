// pubsub: both directions at once. Publishes hello on "chatter", and toggles the LED on "toggle_led".
//
// Wiring: none.
// Try it:  rostether serve /dev/ttyACM0
//          rostether topic echo /chatter
//          rostether topic pub -1 /toggle_led std_msgs/Empty

#include <ros.h>
#include <std_msgs/Empty.h>
#include <std_msgs/String.h>

ros::NodeHandle nh;

const int LED = 13;

void toggle(const std_msgs::Empty&) {
  digitalWrite(LED, HIGH - digitalRead(LED));
}
ros::Subscriber<std_msgs::Empty> sub("toggle_led", &toggle);

std_msgs::String text;
ros::Publisher chatter("chatter", &text);

void setup() {
  pinMode(LED, OUTPUT);
  nh.initNode();
  nh.advertise(chatter);
  nh.subscribe(sub);
}

void loop() {
  text.data = "hello world!";
  chatter.publish(&text);
  nh.spinOnce();
  delay(500);
}
