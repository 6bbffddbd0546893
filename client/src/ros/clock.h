// The host's time: the host's last answer plus the board's milliseconds since then.
#ifndef ROS_CLOCK_H_
#define ROS_CLOCK_H_

#include <stdint.h>
#include <string.h>

#include "ros/inlining.h"
#include "ros/time.h"

namespace ros {

// The members of Time without its constructor, so that zeros in memory are a valid clock.
struct Moment {
  uint32_t sec;
  uint32_t nsec;
};

class Clock {
 public:
  // Returns the time at `now_ms`, and makes it the new reference: the millisecond counter may overflow after 49 days.
  //
  // The time does not go back: after an answer below the last returned time, it stops until the host's time is later.
  // Only if the host's clock was set back by more than MAX_HOLD_S does it follow the host back.
  ROS_APART const Moment& at(uint32_t now_ms) {
    uint32_t elapsed_ms = now_ms - moment_ms_;
    moment_ms_ = now_ms;
    uint32_t sec = moment_.sec;
    if (elapsed_ms >= 1000) {
      sec += elapsed_ms / 1000;
      elapsed_ms %= 1000;
    }
    // A million per millisecond, in factors of 16 bits, which are single steps of an AVR's multiplier.
    uint32_t nsec = moment_.nsec + (static_cast<uint32_t>(static_cast<uint16_t>(elapsed_ms)) * uint16_t(15625) << 6);
    normalizeSecNSec(sec, nsec);
    moment_.sec = sec;
    moment_.nsec = nsec;
    Returned& last = returned();
    // Negative differences wrap to large numbers.
    const uint32_t behind_s = last.moment.sec - sec;
    if (last.clock != this || behind_s >= MAX_HOLD_S || (behind_s == 0 && nsec >= last.moment.nsec)) {
      last.clock = this;
      last.moment = moment_;
    }
    return last.moment;
  }

  void set(const Time& moment, uint32_t then_ms) {
    moment_.sec = moment.sec;
    moment_.nsec = moment.nsec;
    returned().clock = nullptr;
    moment_ms_ = then_ms;
  }

  // Stores the host's time at the moment `then_ms`, 8 bytes as on the wire. `at` computes the time from it, so a
  // sketch that does not use the time does not contain that code.
  void follow(const uint8_t* host, uint32_t then_ms) {
    memcpy(&moment_, host, 8);
    moment_ms_ = then_ms;
  }

 private:
  // Longer than any round trip, so that late answers do not set the clock back. The clock must not stop for much
  // longer.
  static const uint32_t MAX_HOLD_S = 10;

  // The last returned time, and the clock that returned it.
  struct Returned {
    const Clock* clock;
    Moment moment;
  };
#if defined(__AVR__)
  // One variable for all clocks: a sketch that does not use the time does not contain it.
  static Returned& returned() {
    static Returned returned;
    return returned;
  }
#else
  Returned& returned() { return returned_; }
  Returned returned_;
#endif

  Moment moment_;
  uint32_t moment_ms_;
};

}  // namespace ros

#endif
