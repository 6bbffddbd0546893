// Ultrasound: the distance that an HC-SR04 measures, 20 times a second on the topic "ultrasound".
//
// Wiring:  sensor VCC - 5V, GND - GND, Trig - pin 6, Echo - pin 5.
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /ultrasound

#include <ros.h>
#include <ros/time.h>
#include <sensor_msgs/Range.h>

const int TRIG = 6;
const int ECHO = 5;

const float SPEED_OF_SOUND = 343.0e-6;        // meters in a microsecond, at 20 degrees Celsius
const unsigned long PERIOD_MS = 50;           // below 25 ms, the last echo would disturb the next one
const unsigned long LONGEST_ECHO_US = 25000;  // there and back over 4 m

ros::NodeHandle nh;

sensor_msgs::Range range_msg;
ros::Publisher pub_range("ultrasound", &range_msg);
unsigned long measured_ms;

// Returns the time at which the echo pin leaves the level; 0 if it does not. Unlike pulseIn(), micros() loses no time
// while bytes are received and sent on the serial line.
unsigned long endOf(int level) {
  const unsigned long began_us = micros();
  while (digitalRead(ECHO) == level) {
    if (micros() - began_us > LONGEST_ECHO_US) return 0;
  }
  return micros();
}

// Returns meters; infinity if there is no echo.
float measureRange() {
  digitalWrite(TRIG, HIGH);  // a pulse of 10 us starts a measurement
  delayMicroseconds(10);
  digitalWrite(TRIG, LOW);
  const unsigned long sent_us = endOf(LOW);
  const unsigned long back_us = endOf(HIGH);
  if (sent_us == 0 || back_us == 0) return INFINITY;
  return (back_us - sent_us) * (SPEED_OF_SOUND / 2);  // the sound goes there and back
}

void setup() {
  nh.initNode();
  nh.advertise(pub_range);

  range_msg.header.frame_id = "ultrasound";
  range_msg.radiation_type = sensor_msgs::Range::ULTRASOUND;
  range_msg.field_of_view = 0.26;  // radians: 15 degrees
  range_msg.min_range = 0.02;      // meters, like all lengths in ROS
  range_msg.max_range = 4.0;

  pinMode(TRIG, OUTPUT);
  pinMode(ECHO, INPUT);
}

void loop() {
  if (millis() - measured_ms >= PERIOD_MS) {
    measured_ms = millis();
    range_msg.range = measureRange();
    range_msg.header.stamp = nh.now();
    pub_range.publish(&range_msg);
  }
  nh.spinOnce();
}
