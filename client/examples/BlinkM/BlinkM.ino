// BlinkM: sets the color of a BlinkM, an RGB light on I2C, from texts on the topic "blinkm":
//   r, g, b, y (yellow), c (cyan), m (magenta), w (white), o (off)     fades to that color
//   S before it, as in "Sr"                                            changes immediately
//
// Wiring:  BlinkM + - 5V, - - GND, d (SDA) - A4, c (SCL) - A5; on a Mega SDA - 20, SCL - 21.
// Try it:  rostether serve /dev/ttyACM0          rostether topic pub -1 /blinkm std_msgs/String "Sm"

#include <Wire.h>
#include <ros.h>
#include <std_msgs/String.h>

const uint8_t BLINKM = 0x09;  // the default address of every BlinkM

ros::NodeHandle nh;

void command(char name, uint8_t red, uint8_t green, uint8_t blue) {
  Wire.beginTransmission(BLINKM);
  Wire.write(name);
  Wire.write(red);
  Wire.write(green);
  Wire.write(blue);
  if (Wire.endTransmission() != 0) nh.logwarn(F("no BlinkM answers on I2C"));
}

void light_cb(const std_msgs::String& light) {
  const bool at_once = light.data[0] == 'S';
  const char color = light.data[at_once ? 1 : 0];
  if (color == '\0' || strchr("rgbycmwo", color) == NULL) {
    nh.logwarn(F("colors are: r g b y c m w o"));
    return;
  }
  const uint8_t red = strchr("rymw", color) ? 255 : 0;
  const uint8_t green = strchr("gycw", color) ? 255 : 0;
  const uint8_t blue = strchr("bcmw", color) ? 255 : 0;
  command(at_once ? 'n' : 'c', red, green, blue);
}

ros::Subscriber<std_msgs::String> sub("blinkm", &light_cb);

void setup() {
  nh.initNode();
  nh.subscribe(sub);
  Wire.begin();
  Wire.beginTransmission(BLINKM);
  Wire.write('o');  // stops the light show that runs after power-on
  Wire.endTransmission();
}

void loop() {
  nh.spinOnce();
  delay(1);
}
