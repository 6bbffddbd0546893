// Hobby servos with the interface of Arduino's Servo library: pulses of 544 to 2400 us every 20 ms on any pin.
// Uses a whole 16-bit timer (Timer5 on the Mega, else Timer1), so analogWrite() does not work on that timer's pins.
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

  // Returns the channel, counted from 0; INVALID_SERVO if the pin does not exist or MAX_SERVOS are in use. The pulses
  // begin with the value that was written last.
  uint8_t attach(int pin) { return attach(pin, MIN_PULSE_WIDTH, MAX_PULSE_WIDTH); }
  uint8_t attach(int pin, int min_us, int max_us);
  // Ends the pulses; the pin stays a low output. The channel is kept for the next attach.
  void detach();
  // Sets the pulses to degrees from 0 to 180, or to microseconds if the value is MIN_PULSE_WIDTH or more.
  void write(int value);
  void writeMicroseconds(int us);
  // Returns degrees.
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
