#ifndef ROS_TIME_H_
#define ROS_TIME_H_

#include <stdint.h>

#include "ros/duration.h"

namespace ros {

// Moves whole seconds from nsec to sec, so that nsec is below 1e9.
inline void normalizeSecNSec(uint32_t& sec, uint32_t& nsec) {
  while (nsec >= 1000000000UL) {
    nsec -= 1000000000UL;
    ++sec;
  }
}

// A time: sec + nsec * 1e-9 since 1970, with nsec < 1e9. Wire: uint32 sec, uint32 nsec (ROS message definition
// "time").
class Time {
 public:
  uint32_t sec;
  uint32_t nsec;

  constexpr Time() : sec(0), nsec(0) {}
  Time(uint32_t seconds, uint32_t nanoseconds) : sec(seconds), nsec(nanoseconds) { normalizeSecNSec(sec, nsec); }

  double toSec() const { return static_cast<double>(sec) + 1e-9 * static_cast<double>(nsec); }

  // A double of four bytes (AVR) has a resolution of about two minutes for current times: prefer sec and nsec there.
  Time& fromSec(double seconds) {
    sec = static_cast<uint32_t>(seconds);
    nsec = static_cast<uint32_t>((seconds - static_cast<double>(sec)) * 1e9 + 0.5);
    normalizeSecNSec(sec, nsec);
    return *this;
  }

  uint64_t toNsec() const { return static_cast<uint64_t>(sec) * 1000000000ULL + nsec; }
  Time& fromNSec(uint64_t nanoseconds) {
    sec = static_cast<uint32_t>(nanoseconds / 1000000000ULL);
    nsec = static_cast<uint32_t>(nanoseconds % 1000000000ULL);
    return *this;
  }

  Time& operator+=(const Duration& span) { return shift(span.sec, span.nsec); }
  Time& operator-=(const Duration& span) { return shift(-span.sec, -span.nsec); }
  Time operator+(const Duration& span) const { return Time(*this) += span; }
  Time operator-(const Duration& span) const { return Time(*this) -= span; }
  Duration operator-(const Time& other) const {
    return Duration(static_cast<int32_t>(sec - other.sec), static_cast<int32_t>(nsec - other.nsec));
  }

  bool operator==(const Time& other) const { return sec == other.sec && nsec == other.nsec; }
  bool operator!=(const Time& other) const { return !(*this == other); }
  bool operator<(const Time& other) const { return sec < other.sec || (sec == other.sec && nsec < other.nsec); }
  bool operator>(const Time& other) const { return other < *this; }
  bool operator<=(const Time& other) const { return !(other < *this); }
  bool operator>=(const Time& other) const { return !(*this < other); }

 private:
  Time& shift(int32_t seconds, int32_t nanoseconds) {
    int32_t fraction = static_cast<int32_t>(nsec) + nanoseconds;
    int32_t carried = 0;
    normalizeSecNSecSigned(carried, fraction);
    sec += static_cast<uint32_t>(seconds + carried);
    nsec = static_cast<uint32_t>(fraction);
    return *this;
  }
};

}  // namespace ros

#endif
