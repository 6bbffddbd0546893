// button_example: publishes on the topic "pushed" when a button is pressed, and when it is released.
//
// Wiring:  a push button between pin 7 and GND; the LED on pin 13 shows that it is pressed.
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /pushed

#include <ros.h>
#include <std_msgs/Bool.h>

const int BUTTON = 7;
const int LED = 13;
const unsigned long SETTLE_MS = 20;  // contacts bounce for a few milliseconds

ros::NodeHandle nh;

std_msgs::Bool pushed;
ros::Publisher pub_pushed("pushed", &pushed);

bool last_reading = false;
unsigned long changed_ms;

void setup() {
  pinMode(BUTTON, INPUT_PULLUP);  // reads HIGH when open, LOW when pressed
  pinMode(LED, OUTPUT);
  nh.initNode();
  nh.advertise(pub_pushed);
}

void loop() {
  const bool reading = digitalRead(BUTTON) == LOW;
  if (reading != last_reading) {
    last_reading = reading;
    changed_ms = millis();
  }
  if (reading != pushed.data && millis() - changed_ms >= SETTLE_MS) {
    pushed.data = reading;
    digitalWrite(LED, reading);
    pub_pushed.publish(&pushed);
  }
  nh.spinOnce();
}
