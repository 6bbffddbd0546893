#ifndef ROS_PLATFORM_BYTE_RING_H_
#define ROS_PLATFORM_BYTE_RING_H_

#include <stdint.h>

namespace ros {

// A ring buffer between a program and an interrupt: one writes and the other reads, without a lock. Zeros, as in static
// memory, are an empty ring: a constructor would have to run before the first interrupt.
template <uint16_t SIZE>
class ByteRing {
 public:
  static_assert((SIZE & (SIZE - 1)) == 0, "the size is a power of two");

  uint16_t count() const { return static_cast<uint16_t>(head_ - tail_) & (SIZE - 1); }
  uint16_t room() const { return static_cast<uint16_t>(SIZE - 1 - count()); }

  // Drops the byte if the ring is full; the checksum of its frame then shows the loss.
  void put(uint8_t byte) {
    if (!room()) return;
    bytes_[head_] = byte;
    head_ = (head_ + 1) & (SIZE - 1);
  }
  // Removes and returns the oldest byte; -1 if the ring is empty.
  int take() {
    if (head_ == tail_) return -1;
    const uint8_t byte = bytes_[tail_];
    tail_ = (tail_ + 1) & (SIZE - 1);
    return byte;
  }

 private:
  volatile uint16_t head_;
  volatile uint16_t tail_;
  volatile uint8_t bytes_[SIZE];
};

}  // namespace ros

#endif
