// The host's time, kept between its answers with the board's milliseconds.
#ifndef ROS_CLOCK_H_
#define ROS_CLOCK_H_

#include <stdint.h>
#include <string.h>

#include "inlining.h"
#include "time.h"

namespace ros {

// Time's members without its constructor, so that a clock may lie in memory that is zeroed at once.
struct Moment {
  uint32_t sec;
  uint32_t nsec;

  bool operator<(const Moment& other) const { return sec < other.sec || (sec == other.sec && nsec < other.nsec); }
};

class Clock {
 public:
  // Time at `now_ms`. Moves the reference along, so that the millisecond counter may overflow after 49 days.
  ROS_NOINLINE const Moment& at(uint32_t now_ms) {
    uint32_t elapsed_ms = now_ms - moment_ms_;
    moment_ms_ = now_ms;
    uint32_t sec = moment_.sec;
    // Mostly once or not at all: cheaper than a division on a processor that has none.
    for (; elapsed_ms >= 1000; elapsed_ms -= 1000) ++sec;
    // A million a millisecond, by factors of 16 bits: a single step of an AVR's multiplier.
    uint32_t nsec = moment_.nsec + (static_cast<uint32_t>(static_cast<uint16_t>(elapsed_ms)) * uint16_t(15625) << 6);
    normalizeSecNSec(sec, nsec);
    moment_.sec = sec;
    moment_.nsec = nsec;
    return moment_ < floor_ ? floor_ : moment_;
  }

  void set(const Time& moment, uint32_t then_ms) {
    moment_.sec = moment.sec;
    moment_.nsec = moment.nsec;
    floor_.sec = 0;
    floor_.nsec = 0;
    moment_ms_ = then_ms;
  }

  // Takes over the host's time of the moment `then_ms`, 8 bytes as on the wire: jumps forward to it, but rather than back
  // it stands still until the host has caught up. Only a host whose clock itself was set back, by more than MAX_HOLD_S,
  // is followed back.
  void follow(const uint8_t* host, uint32_t then_ms, uint32_t now_ms) {
    floor_ = at(now_ms);
    memcpy(&moment_, host, 8);
    moment_ms_ = then_ms;
    if (floor_.sec - moment_.sec >= MAX_HOLD_S) floor_.sec = 0;
  }

 private:
  // Longer than any round trip, shorter than a user would put up with a clock that stands still.
  static const uint32_t MAX_HOLD_S = 10;

  Moment moment_;
  // The latest time that was told.
  Moment floor_;
  uint32_t moment_ms_;
};

}  // namespace ros

#endif
