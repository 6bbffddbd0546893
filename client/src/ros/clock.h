// The host's time, kept between its answers with the board's milliseconds.
#ifndef ROS_CLOCK_H_
#define ROS_CLOCK_H_

#include <stdint.h>
#include <string.h>

#include "inlining.h"
#include "time.h"

namespace ros {

class Clock {
 public:
  constexpr Clock() : moment_(), floor_(), moment_ms_(0) {}

  // Time at `now_ms`. Moves the reference along, so that the millisecond counter may overflow after 49 days.
  ROS_NOINLINE const Time& at(uint32_t now_ms) {
    uint32_t elapsed_ms = now_ms - moment_ms_;
    moment_ms_ = now_ms;
    uint32_t sec = moment_.sec;
    // Mostly once or not at all: cheaper than a division on a processor that has none.
    for (; elapsed_ms >= 1000; elapsed_ms -= 1000) ++sec;
    uint32_t nsec = moment_.nsec + elapsed_ms * 1000000UL;
    normalizeSecNSec(sec, nsec);
    moment_.sec = sec;
    moment_.nsec = nsec;
    return moment_ < floor_ ? floor_ : moment_;
  }

  void set(const Time& moment, uint32_t then_ms) {
    moment_ = moment;
    floor_ = Time();
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

  Time moment_;
  // The latest time that was told.
  Time floor_;
  uint32_t moment_ms_;
};

}  // namespace ros

#endif
