// The sensors for the OpenCR of a TurtleBot3, on the pins that ROBOTIS uses. A missing sensor reads 0.
#ifndef SENSORS_H
#define SENSORS_H

#include <Arduino.h>
#include <turtlebot3_msgs/SensorState.h>

const int SONAR_TRIGGER = BDPIN_GPIO_1;
const int SONAR_ECHO = BDPIN_GPIO_2;
const int ILLUMINATION = A1;
// The connectors for ROBOTIS' OLLO sensors: connector 2 has an infrared sensor, 3 and 4 have touch sensors.
const int OLLO_POWER = 46;
const int CLIFF_LIGHT = 44;
const int CLIFF = 45;
const int BUMPER_BACK = 72;
const int BUMPER_FRONT = 75;
const int LEDS[] = {BDPIN_LED_USER_1, BDPIN_LED_USER_2, BDPIN_LED_USER_3, BDPIN_LED_USER_4};

const float FULL_VOLTS = 12.4;  // three lithium cells
const float EMPTY_VOLTS = 11.0;
// The time of an echo from 0.68 m. The program waits for the echo between two measurements of the IMU.
const unsigned long SONAR_LIMIT_US = 4000;

class Sensors {
 public:
  float sonar = 0;  // cm, 0: nothing within 68 cm

  void begin() {
    pinMode(OLLO_POWER, OUTPUT);
    digitalWrite(OLLO_POWER, HIGH);
    pinMode(CLIFF_LIGHT, OUTPUT);
    pinMode(BUMPER_BACK, INPUT_PULLUP);
    pinMode(BUMPER_FRONT, INPUT_PULLUP);
    pinMode(SONAR_TRIGGER, OUTPUT);
    pinMode(SONAR_ECHO, INPUT);
    for (uint8_t i = 0; i < 4; ++i) pinMode(LEDS[i], OUTPUT);
  }

  uint8_t bumper() const {
    return (digitalRead(BUMPER_FRONT) == HIGH ? turtlebot3_msgs::SensorState::BUMPER_FORWARD : 0) |
           (digitalRead(BUMPER_BACK) == HIGH ? turtlebot3_msgs::SensorState::BUMPER_BACKWARD : 0);
  }
  uint8_t buttons() const {
    return (digitalRead(BDPIN_PUSH_SW_1) == HIGH ? turtlebot3_msgs::SensorState::BUTTON0 : 0) |
           (digitalRead(BDPIN_PUSH_SW_2) == HIGH ? turtlebot3_msgs::SensorState::BUTTON1 : 0);
  }
  // The amount of the infrared sensor's light that the floor reflects, 0 to 1023.
  float cliff() const {
    digitalWrite(CLIFF_LIGHT, HIGH);
    delayMicroseconds(15);
    const float light = analogRead(CLIFF);
    digitalWrite(CLIFF_LIGHT, LOW);
    return light;
  }
  float illumination() const { return analogRead(ILLUMINATION); }  // 0 to 1023
  float batteryVolts() const { return getPowerInVoltage(); }
  float batteryPart() const {
    const float part = (batteryVolts() - EMPTY_VOLTS) / (FULL_VOLTS - EMPTY_VOLTS);
    return constrain(part, 0.0f, 1.0f);
  }

  void measureSonar() {
    digitalWrite(SONAR_TRIGGER, HIGH);
    delayMicroseconds(10);
    digitalWrite(SONAR_TRIGGER, LOW);
    sonar = pulseIn(SONAR_ECHO, HIGH, SONAR_LIMIT_US) * 0.0171f;  // cm per microsecond, there and back
  }

  // Lights the board's LEDs, which light at LOW. Bit 0 is USER1.
  void show(uint8_t lit) {
    lit_ = lit;
    for (uint8_t i = 0; i < 4; ++i) digitalWrite(LEDS[i], lit >> i & 1 ? LOW : HIGH);
  }
  uint8_t lit() const { return lit_; }

 private:
  uint8_t lit_ = 0;
};

#endif
