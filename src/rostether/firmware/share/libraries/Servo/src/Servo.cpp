// One free-running timer makes all pulses, one after the other: its compare interrupt ends a pulse and begins the next.
// The width of a pulse is measured from the moment when its pin goes high. An interrupt that begins a pulse late
// therefore does not change its width; only a late end does.
#include "Servo.h"

#include <Arduino.h>

#if defined(TCCR5A)
#define SERVO_(before, after) before##5##after
#define SERVO_INTERRUPT TIMER5_COMPA_vect
#else
#define SERVO_(before, after) before##1##after
#define SERVO_INTERRUPT TIMER1_COMPA_vect
#endif

namespace {

// The timer counts at an eighth of the clock: two ticks a microsecond at 16 MHz.
constexpr uint16_t ticks(uint16_t us) {
  // On all usual boards a microsecond is a whole number of ticks, which needs no division.
  return F_CPU % 8000000UL == 0 ? static_cast<uint16_t>(us * (F_CPU / 8000000UL))
                                : static_cast<uint16_t>(us * (F_CPU / 1000UL) / 8000UL);
}

// The time from the compare match until the pin is cleared is 71 cycles longer than the time from setting the pin until
// the timer is read (counted in a simulator).
constexpr uint16_t kTrim = 9;
// The timer could pass a nearer compare value while it is written.
constexpr uint16_t kSoon = 32;

struct Channel {
  volatile uint8_t* port;
  uint8_t mask;  // 0 while the channel makes no pulses
  uint16_t width;
};

Channel channels[MAX_SERVOS];
uint8_t used = 0;
uint8_t current = 0;  // the channel whose pulse is on; `used` or more in the gap between two rounds
uint16_t round_start = 0;

void start() {
  SERVO_(TCCR, A) = 0;
  SERVO_(TCCR, B) = _BV(SERVO_(CS, 1));
  current = MAX_SERVOS;
  SERVO_(OCR, A) = SERVO_(TCNT, ) + kSoon;
  SERVO_(TIFR, ) = _BV(SERVO_(OCF, A));
  SERVO_(TIMSK, ) |= _BV(SERVO_(OCIE, A));
}

bool is_running() { return SERVO_(TIMSK, ) & _BV(SERVO_(OCIE, A)); }

}  // namespace

ISR(SERVO_INTERRUPT) {
  uint8_t next = current;
  if (next < used) {
    *channels[next].port &= ~channels[next].mask;
    ++next;
  } else {
    next = 0;
    round_start = SERVO_(TCNT, );
  }
  while (next < used && !channels[next].mask) ++next;
  current = next;
  if (next < used) {
    const Channel& channel = channels[next];
    *channel.port |= channel.mask;
    SERVO_(OCR, A) = SERVO_(TCNT, ) + channel.width;
    return;
  }
  const uint16_t now = SERVO_(TCNT, );
  const uint16_t round = ticks(REFRESH_INTERVAL);
  current = MAX_SERVOS;
  SERVO_(OCR, A) = static_cast<uint16_t>(now - round_start) < round - kSoon ? round_start + round : now + kSoon;
}

uint8_t Servo::attach(int pin, int min_us, int max_us) {
  const uint8_t port = digitalPinToPort(pin);
  if (port == NOT_A_PORT) return INVALID_SERVO;
  if (!channel_) {
    if (used == MAX_SERVOS) return INVALID_SERVO;
    channel_ = ++used;
  }
  detach();
  min_us_ = min_us;
  max_us_ = max_us;
  writeMicroseconds(pulse_us_);
  Channel& channel = channels[channel_ - 1];
  const uint8_t mask = digitalPinToBitMask(pin);
  channel.port = portOutputRegister(port);
  const uint8_t state = SREG;
  cli();
  *channel.port &= ~mask;
  *portModeRegister(port) |= mask;
  channel.mask = mask;
  if (!is_running()) start();
  SREG = state;
  return channel_ - 1;
}

void Servo::detach() {
  if (!attached()) return;
  Channel& channel = channels[channel_ - 1];
  const uint8_t state = SREG;
  cli();
  *channel.port &= ~channel.mask;
  channel.mask = 0;
  SREG = state;
}

void Servo::write(int value) {
  if (value < MIN_PULSE_WIDTH) {
    const uint16_t span = max_us_ - min_us_;
    value = min_us_ + static_cast<int>(constrain(value, 0, 180) * static_cast<uint32_t>(span) / 180);
  }
  writeMicroseconds(value);
}

void Servo::writeMicroseconds(int us) {
  pulse_us_ = constrain(us, min_us_, max_us_);
  if (!channel_) return;
  const uint16_t width = ticks(pulse_us_) - kTrim;
  const uint8_t state = SREG;
  cli();
  channels[channel_ - 1].width = width;
  SREG = state;
}

int Servo::read() const { return map(pulse_us_ + 1, min_us_, max_us_, 0, 180); }

bool Servo::attached() const { return channel_ && channels[channel_ - 1].mask; }
