// The board OpenCR as a Linux program: the part of its Arduino core that sketches for robots use. A simulation is at
// the other end of its pins and lines (board.cpp). `rostether board run --board opencr` builds the program, and starts
// both.
#ifndef OPENCR_ON_LINUX_ARDUINO_H_
#define OPENCR_ON_LINUX_ARDUINO_H_

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "Print.h"

typedef uint8_t byte;
typedef bool boolean;

#define LOW 0
#define HIGH 1
#define FALSE 0
#define TRUE 1
#define INPUT 0
#define OUTPUT 1
#define INPUT_PULLUP 2
#define INPUT_ANALOG 3
#define INPUT_PULLDOWN 4
#define CHANGE 2
#define FALLING 3
#define RISING 4
#define PI 3.1415926535897932384626433832795
#define TWO_PI (2 * PI)
#define HALF_PI (PI / 2)
#define DEG_TO_RAD (PI / 180)
#define RAD_TO_DEG (180 / PI)
#define constrain(value, low, high) ((value) < (low) ? (low) : (value) > (high) ? (high) : (value))
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#undef abs
#define abs(value) ((value) > 0 ? (value) : -(value))
#define sq(value) ((value) * (value))
#define radians(degrees) ((degrees) * DEG_TO_RAD)
#define degrees(radians) ((radians) * RAD_TO_DEG)
#define bit(number) (1UL << (number))
#define lowByte(word) ((uint8_t)((word) & 0xff))
#define highByte(word) ((uint8_t)((word) >> 8))
// Macros of the core, which sketches and libraries must not collide with.
#define OK 0x0000
#define SERIAL 0
#define DISPLAY 1
#define DEFAULT 1
#define EXTERNAL 0

// Pins, with the names and numbers of the board.
const uint8_t A0 = 16, A1 = 17, A2 = 18, A3 = 19, A4 = 20, A5 = 21;
#define LED_BUILTIN 13
#define BDPIN_LED_USER_1 22
#define BDPIN_LED_USER_2 23
#define BDPIN_LED_USER_3 24
#define BDPIN_LED_USER_4 25
#define BDPIN_DIP_SW_1 26
#define BDPIN_DIP_SW_2 27
#define BDPIN_SPI_CS_IMU 28
#define BDPIN_BAT_PWR_ADC 29
#define BDPIN_BUZZER 31
#define BDPIN_DXL_PWR_EN 32
#define BDPIN_PUSH_SW_1 34
#define BDPIN_PUSH_SW_2 35
#define BDPIN_LED_STATUS 36
#define BDPIN_GPIO_1 50
#define BDPIN_GPIO_2 51
#define BDPIN_GPIO_3 52
#define BDPIN_GPIO_4 53
#define BDPIN_GPIO_5 54
#define BDPIN_GPIO_6 55
#define BDPIN_GPIO_7 56
#define BDPIN_GPIO_8 57
#define BDPIN_GPIO_9 58
#define BDPIN_GPIO_10 59
#define BDPIN_GPIO_11 60
#define BDPIN_GPIO_12 61
#define BDPIN_GPIO_13 62
#define BDPIN_GPIO_14 63
#define BDPIN_GPIO_15 64
#define BDPIN_GPIO_16 65
#define BDPIN_GPIO_17 66
#define BDPIN_GPIO_18 67
#define PINS_COUNT 85

void pinMode(int pin, int mode);
void digitalWrite(int pin, int level);
int digitalRead(int pin);
int analogRead(int pin);  // 0 to 1023
void tone(int pin, unsigned int hertz, unsigned long length_ms = 0);
void noTone(int pin);
unsigned long pulseIn(int pin, int level, unsigned long timeout_us = 1000000);

unsigned long millis();
unsigned long micros();
void delay(unsigned long wait_ms);
void delayMicroseconds(unsigned long wait_us);

float getPowerInVoltage();
uint8_t getPushButton();
void drv_dxl_tx_enable(int is_sending);

class Stream : public Print {
 public:
  virtual int available() = 0;
  virtual int read() = 0;
};

// A line that is a file descriptor, whose number is in an environment variable.
class Line : public Stream {
 public:
  explicit Line(const char* variable);
  void begin(unsigned long) {}
  void end() {}
  int available() override;
  int read() override;
  using Print::write;
  size_t write(const uint8_t* bytes, size_t size) override;
  void flush() {}
  int descriptor() const { return fd_; }

 private:
  const int fd_;
  uint8_t received_[4096];
  size_t received_bytes_;
  size_t read_bytes_;
};

typedef Line USBSerial;
typedef Line UARTClass;
extern USBSerial Serial;
extern UARTClass Serial3;  // the servos
extern UARTClass Serial4;  // Bluetooth
#define SerialBT2 Serial4

void setup();
void loop();

#endif
