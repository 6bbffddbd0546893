// The host's time, kept between its answers with the board's milliseconds.
#ifndef ROS_CLOCK_H_
#define ROS_CLOCK_H_

#include <stdint.h>

#include "time.h"

namespace ros {

class Clock {
 public:
  constexpr Clock() : moment_(), floor_(), moment_ms_(0) {}

  // Time at `now_ms`. Moves the reference along, so that the millisecond counter may overflow after 49 days.
  Time at(uint32_t now_ms) {
    uint32_t elapsed_ms = now_ms - moment_ms_;
    moment_ms_ = now_ms;
    // Mostly once or not at all: cheaper than a division on a processor that has none.
    for (; elapsed_ms >= 1000; elapsed_ms -= 1000) ++moment_.sec;
    moment_.nsec += elapsed_ms * 1000000UL;
    normalizeSecNSec(moment_.sec, moment_.nsec);
    if (moment_ < floor_) return floor_;
    return moment_;
  }

  void set(const Time& moment, uint32_t then_ms) {
    moment_ = moment;
    floor_ = Time();
    moment_ms_ = then_ms;
  }

  // Takes over the host's time of the moment `then_ms`: jumps forward to it, but rather than back it stands still
  // until the host has caught up. Only a host whose clock itself was set back, by more than MAX_HOLD_S, is followed back.
  void follow(const Time& host, uint32_t then_ms, uint32_t now_ms) {
    const Time own = at(now_ms);
    set(host, then_ms);
    if (own.sec - host.sec < MAX_HOLD_S) floor_ = own;
  }

 private:
  // Longer than any round trip, shorter than a user would put up with a clock that stands still.
  static const uint32_t MAX_HOLD_S = 10;

  Time moment_;
  // The latest time that was told.
  Time floor_;
  uint32_t moment_ms_;
};

}  // namespace ros

#endif
