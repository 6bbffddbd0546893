#ifndef ROS_BUFFER_WRITER_H_
#define ROS_BUFFER_WRITER_H_

#include <stddef.h>
#include <string.h>

#include "writer.h"

namespace ros {

// Writes into memory that is known to be large enough.
class BufferWriter : public Writer<BufferWriter> {
 public:
  explicit BufferWriter(unsigned char* buffer) : start_(buffer), next_(buffer) {}

  void put(const void* bytes, size_t count) {
    if (count == 0) return;
    memcpy(next_, bytes, count);
    next_ += count;
  }
  size_t length() const { return static_cast<size_t>(next_ - start_); }

 private:
  unsigned char* start_;
  unsigned char* next_;
};

}  // namespace ros

#endif
