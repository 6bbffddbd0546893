// LedByte: four LEDs show the bits of the number that is received on the topic "led_out": 5 lights the first and the
// third.
//
// Wiring:  OpenCR: none, its LEDs USER1 to USER4 are on the board. Other boards: an LED with a resistor of 1 kiloohm
//          from each of the pins 4, 5, 6, 7 to GND.
// Try it:  rostether serve /dev/ttyACM0          rostether topic pub -1 /led_out std_msgs/Byte 5

#include <ros.h>
#include <std_msgs/Byte.h>

#if defined(BDPIN_LED_USER_1)
const int LEDS[4] = {BDPIN_LED_USER_1, BDPIN_LED_USER_2, BDPIN_LED_USER_3, BDPIN_LED_USER_4};
const int LIT = LOW;  // the LEDs are wired from the supply to the pin
const int DARK = HIGH;
#else
const int LEDS[4] = {4, 5, 6, 7};
const int LIT = HIGH;
const int DARK = LOW;
#endif

ros::NodeHandle nh;

void show(const std_msgs::Byte& number) {
  for (int i = 0; i < 4; i++) {
    digitalWrite(LEDS[i], number.data & (1 << i) ? LIT : DARK);
  }
}

ros::Subscriber<std_msgs::Byte> sub("led_out", &show);

void setup() {
  for (int i = 0; i < 4; i++) {
    pinMode(LEDS[i], OUTPUT);
    digitalWrite(LEDS[i], DARK);
  }
  nh.initNode();
  nh.subscribe(sub);
}

void loop() {
  nh.spinOnce();
}
