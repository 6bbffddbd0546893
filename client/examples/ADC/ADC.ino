// ADC: all six analog inputs on the topic "adc": 0 for 0 V to 1023 for (almost) 5 V.
//
// Wiring:  anything between 0 and 5 V to A0 ... A5, a potentiometer for instance.
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /adc

#include <ros.h>
#include <rosserial_arduino/Adc.h>

ros::NodeHandle nh;

rosserial_arduino::Adc adc;
ros::Publisher pub_adc("adc", &adc);

// Returns the mean of four samples, rounded. The first sample after a change of the input is not used: it may still
// show the old input.
uint16_t measure(int input) {
  analogRead(input);
  uint16_t sum = 2;
  for (int i = 0; i < 4; i++) sum += analogRead(input);
  return sum / 4;
}

void setup() {
  nh.initNode();
  nh.advertise(pub_adc);
}

void loop() {
  adc.adc0 = measure(A0);
  adc.adc1 = measure(A1);
  adc.adc2 = measure(A2);
  adc.adc3 = measure(A3);
  adc.adc4 = measure(A4);
  adc.adc5 = measure(A5);
  pub_adc.publish(&adc);
  nh.spinOnce();
  delay(50);
}
