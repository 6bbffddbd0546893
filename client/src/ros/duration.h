#ifndef ROS_DURATION_H_
#define ROS_DURATION_H_

#include <stdint.h>

namespace ros {

// Moves whole seconds from nsec to sec, so that nsec is in [0, 1e9).
inline void normalizeSecNSecSigned(int32_t& sec, int32_t& nsec) {
  while (nsec < 0) {
    nsec += 1000000000L;
    --sec;
  }
  while (nsec >= 1000000000L) {
    nsec -= 1000000000L;
    ++sec;
  }
}

// A duration, which may be negative: sec + nsec * 1e-9 with 0 <= nsec < 1e9. Wire: int32 sec, int32 nsec (ROS message
// definition "duration").
class Duration {
 public:
  int32_t sec;
  int32_t nsec;

  constexpr Duration() : sec(0), nsec(0) {}
  Duration(int32_t seconds, int32_t nanoseconds) : sec(seconds), nsec(nanoseconds) {
    normalizeSecNSecSigned(sec, nsec);
  }
  explicit Duration(double seconds) { fromSec(seconds); }

  double toSec() const { return static_cast<double>(sec) + 1e-9 * static_cast<double>(nsec); }

  Duration& fromSec(double seconds) {
    sec = static_cast<int32_t>(seconds);
    if (static_cast<double>(sec) > seconds) --sec;
    nsec = static_cast<int32_t>((seconds - static_cast<double>(sec)) * 1e9 + 0.5);
    normalizeSecNSecSigned(sec, nsec);
    return *this;
  }

  int64_t toNSec() const { return static_cast<int64_t>(sec) * 1000000000LL + nsec; }

  Duration& operator+=(const Duration& other) {
    sec += other.sec;
    nsec += other.nsec;
    normalizeSecNSecSigned(sec, nsec);
    return *this;
  }
  Duration& operator-=(const Duration& other) {
    sec -= other.sec;
    nsec -= other.nsec;
    normalizeSecNSecSigned(sec, nsec);
    return *this;
  }
  Duration& operator*=(double factor) { return fromSec(toSec() * factor); }

  Duration operator+(const Duration& other) const { return Duration(*this) += other; }
  Duration operator-(const Duration& other) const { return Duration(*this) -= other; }
  Duration operator-() const { return Duration(-sec, -nsec); }
  Duration operator*(double factor) const { return Duration(*this) *= factor; }

  bool operator==(const Duration& other) const { return sec == other.sec && nsec == other.nsec; }
  bool operator!=(const Duration& other) const { return !(*this == other); }
  bool operator<(const Duration& other) const {
    return sec < other.sec || (sec == other.sec && nsec < other.nsec);
  }
  bool operator>(const Duration& other) const { return other < *this; }
  bool operator<=(const Duration& other) const { return !(other < *this); }
  bool operator>=(const Duration& other) const { return !(*this < other); }
};

}  // namespace ros

#endif
