// Temperature: degrees Celsius from a TMP36, once a second on the topic "temperature".
//
// Wiring:  flat side towards you, from the left: 5V, A0, GND.
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /temperature

#include <ros.h>
#include <std_msgs/Float32.h>

const int SENSOR = A0;
const int SAMPLES = 16;  // their mean has less noise

ros::NodeHandle nh;

std_msgs::Float32 temperature;
ros::Publisher pub_temperature("temperature", &temperature);
unsigned long measured_ms;

// The sensor gives 10 mV for each degree, and 500 mV at 0 degrees.
float measureCelsius() {
  long sum = 0;
  for (int i = 0; i < SAMPLES; i++) sum += analogRead(SENSOR);
  const float volts = sum * (5.0 / 1024 / SAMPLES);
  return (volts - 0.5) * 100;
}

void setup() {
  nh.initNode();
  nh.advertise(pub_temperature);
}

void loop() {
  if (millis() - measured_ms >= 1000) {
    measured_ms = millis();
    temperature.data = measureCelsius();
    pub_temperature.publish(&temperature);
  }
  nh.spinOnce();
}
