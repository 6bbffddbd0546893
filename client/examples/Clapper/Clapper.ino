// Clapper: publishes on the topic "clap" when you clap twice.
//
// Wiring:  a piezo disc between A0 and GND, and a resistor of 1 megaohm in parallel.
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /clap

#include <ros.h>
#include <std_msgs/Empty.h>

const int MICROPHONE = A0;
const int LOUD = 200;                      // 0 to 1023; increase it in a noisy room
const unsigned long ECHO_MS = 100;         // the echo of a clap is shorter
const unsigned long LONGEST_PAUSE_MS = 600;  // between the two claps

ros::NodeHandle nh;

std_msgs::Empty clap;
ros::Publisher pub_clap("clap", &clap);

bool heard_first = false;
unsigned long heard_ms;

void setup() {
  nh.initNode();
  nh.advertise(pub_clap);
}

void loop() {
  const unsigned long since_ms = millis() - heard_ms;
  if (since_ms > LONGEST_PAUSE_MS) heard_first = false;

  if (since_ms > ECHO_MS && analogRead(MICROPHONE) > LOUD) {
    heard_ms = millis();
    if (heard_first) pub_clap.publish(&clap);
    heard_first = !heard_first;
  }
  nh.spinOnce();
}
