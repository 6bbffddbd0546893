// Hobby servos with the interface of Arduino's Servo library: pulses of 544 to 2400 us every 20 ms on any pin.
// Uses one 16-bit timer whole, Timer1 or on the Mega Timer5, so analogWrite() on that timer's pins does not work.
#ifndef Servo_h
#define Servo_h

#include <stdint.h>

#define MIN_PULSE_WIDTH 544
#define MAX_PULSE_WIDTH 2400
#define DEFAULT_PULSE_WIDTH 1500
#define REFRESH_INTERVAL 20000
#define MAX_SERVOS 12
#define INVALID_SERVO 255

class Servo {
 public:
  constexpr Servo()
      : channel_(0), min_us_(MIN_PULSE_WIDTH), max_us_(MAX_PULSE_WIDTH), pulse_us_(DEFAULT_PULSE_WIDTH) {}

  // The channel from 0, or INVALID_SERVO when MAX_SERVOS are in use. Pulses begin with what was written last.
  uint8_t attach(int pin) { return attach(pin, MIN_PULSE_WIDTH, MAX_PULSE_WIDTH); }
  uint8_t attach(int pin, int min_us, int max_us);
  // Ends the pulses; the pin stays a low output. The channel is kept for the next attach.
  void detach();
  // Degrees from 0 to 180, or microseconds when it is MIN_PULSE_WIDTH or more.
  void write(int value);
  void writeMicroseconds(int us);
  // Degrees.
  int read() const;
  int readMicroseconds() const { return pulse_us_; }
  bool attached() const;

 private:
  uint8_t channel_;  // from 1; 0 before the first attach
  int min_us_;
  int max_us_;
  int pulse_us_;
};

#endif
