// Blink: the LED changes each time a message arrives on the topic "toggle_led".
//
// Wiring: none, the LED on pin 13 is on the board.
// Try it:  rostether serve /dev/ttyACM0          rostether topic pub -1 /toggle_led std_msgs/Empty

#include <ros.h>
#include <std_msgs/Empty.h>

ros::NodeHandle nh;

const int LED = 13;

void toggle(const std_msgs::Empty&) {
  digitalWrite(LED, HIGH - digitalRead(LED));
}

ros::Subscriber<std_msgs::Empty> sub("toggle_led", &toggle);

void setup() {
  pinMode(LED, OUTPUT);
  nh.initNode();
  nh.subscribe(sub);
}

void loop() {
  nh.spinOnce();  // runs toggle() for each received message
  delay(1);
}
