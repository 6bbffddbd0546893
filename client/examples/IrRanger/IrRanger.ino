// IrRanger: the distance that a Sharp GP2Y0A41SK0F measures, 4 to 30 cm, 20 times a second on the topic "range_data".
//
// Wiring:  sensor red - 5V, black - GND, yellow - A0.
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /range_data

#include <ros.h>
#include <ros/time.h>
#include <sensor_msgs/Range.h>

const int SENSOR = A0;
const unsigned long PERIOD_MS = 50;  // the sensor takes 17 ms for a measurement

ros::NodeHandle nh;

sensor_msgs::Range range_msg;
ros::Publisher pub_range("range_data", &range_msg);
unsigned long measured_ms;

// Returns meters. In the data sheet, the voltage is proportional to 1 / (distance + 0.42 cm):
//   volts = 12.2 / (centimeters + 0.42)
float measureRange() {
  const float volts = analogRead(SENSOR) * (5.0 / 1024);
  if (volts < 0.3) return INFINITY;  // no object in range
  return (12.2 / volts - 0.42) * 0.01;
}

void setup() {
  nh.initNode();
  nh.advertise(pub_range);

  range_msg.header.frame_id = "ir_ranger";
  range_msg.radiation_type = sensor_msgs::Range::INFRARED;
  range_msg.field_of_view = 0.01;
  range_msg.min_range = 0.04;
  range_msg.max_range = 0.3;
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
