#ifndef ROS_BUFFER_WRITER_H_
#define ROS_BUFFER_WRITER_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/float64.h"

namespace ros {

// A sink that writes to a buffer, which must be large enough.
class BufferWriter {
 public:
  explicit BufferWriter(unsigned char* buffer) : start_(buffer), next_(buffer) {}

  void put(const void* bytes, size_t count) {
    if (count == 0) return;
    memcpy(next_, bytes, count);
    next_ += count;
  }
  void widen(const void* floats, size_t bytes) {
    const uint8_t* next = static_cast<const uint8_t*>(floats);
    for (const uint8_t* end = next + bytes; next != end; next += 4, next_ += 8) widenFloat(next, next_);
  }
  void count(size_t length) {
    const uint32_t prefix = static_cast<uint32_t>(length);
    put(&prefix, 4);
  }
  void string(const char* text) {
    const size_t length = text ? strlen(text) : 0;
    count(length);
    put(text, length);
  }
  size_t length() const { return static_cast<size_t>(next_ - start_); }

 private:
  unsigned char* start_;
  unsigned char* next_;
};

}  // namespace ros

#endif
