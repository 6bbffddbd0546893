#ifndef ROS_PLATFORM_POSIX_CLOCK_H_
#define ROS_PLATFORM_POSIX_CLOCK_H_

#include <stdint.h>
#include <time.h>
#include <unistd.h>

namespace ros {

// Returns the time, in milliseconds, of a clock that is never adjusted.
inline uint32_t posixMilliseconds() {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<uint32_t>(static_cast<uint64_t>(now.tv_sec) * 1000 + static_cast<uint64_t>(now.tv_nsec) / 1000000);
}

}  // namespace ros

#endif
