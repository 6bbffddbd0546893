// The host's time, kept between its answers with the board's milliseconds.
#ifndef ROS_CLOCK_H_
#define ROS_CLOCK_H_

#include <stdint.h>
#include <string.h>

#include "ros/inlining.h"
#include "ros/time.h"

namespace ros {

// Time's members without its constructor, so that a clock may lie in memory that is zeroed at once.
struct Moment {
  uint32_t sec;
  uint32_t nsec;
};

class Clock {
 public:
  // Time at `now_ms`. Moves the reference along, so that the millisecond counter may overflow after 49 days.
  //
  // It never goes back: after an answer below the time last returned, it stands still until the host has caught
  // up. Only a host whose clock itself was set back, by more than MAX_HOLD_S, is followed back.
  ROS_APART const Moment& at(uint32_t now_ms) {
    uint32_t elapsed_ms = now_ms - moment_ms_;
    moment_ms_ = now_ms;
    uint32_t sec = moment_.sec;
    if (elapsed_ms >= 1000) {
      sec += elapsed_ms / 1000;
      elapsed_ms %= 1000;
    }
    // A million a millisecond, by factors of 16 bits: a single step of an AVR's multiplier.
    uint32_t nsec = moment_.nsec + (static_cast<uint32_t>(static_cast<uint16_t>(elapsed_ms)) * uint16_t(15625) << 6);
    normalizeSecNSec(sec, nsec);
    moment_.sec = sec;
    moment_.nsec = nsec;
    // Negative differences wrap to billions.
    const uint32_t behind_s = returned_.sec - sec;
    if (behind_s >= MAX_HOLD_S || (behind_s == 0 && nsec >= returned_.nsec)) returned_ = moment_;
    return returned_;
  }

  void set(const Time& moment, uint32_t then_ms) {
    moment_.sec = moment.sec;
    moment_.nsec = moment.nsec;
    returned_.sec = 0;
    moment_ms_ = then_ms;
  }

  // Takes over the host's time of the moment `then_ms`, 8 bytes as on the wire. `at` computes the time from
  // it, so a sketch that never asks for the time does not contain that code.
  void follow(const uint8_t* host, uint32_t then_ms) {
    memcpy(&moment_, host, 8);
    moment_ms_ = then_ms;
  }

 private:
  // Longer than any round trip, and short enough for a clock to stop.
  static const uint32_t MAX_HOLD_S = 10;

  Moment moment_;
  // The latest time that was returned.
  Moment returned_;
  uint32_t moment_ms_;
};

}  // namespace ros

#endif
