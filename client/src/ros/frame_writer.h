#ifndef ROS_FRAME_WRITER_H_
#define ROS_FRAME_WRITER_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "flash.h"
#include "float64.h"
#include "inlining.h"
#include "topic_id.h"

namespace ros {

// Where frames go, a chunk at a time.
class FrameSink {
 public:
  // Hands bytes to the line. False once the line has stopped taking them; the rest of the frame is then lost.
  virtual bool transmit(uint8_t* bytes, uint16_t count) = 0;

 protected:
  ~FrameSink() {}
};

// Sink that sends a message as a frame: its length is known beforehand, its bytes stream through a small
// chunk, its checksum is summed up on the way. No buffer for the whole of it.
class FrameWriter {
 public:
  // The most that goes to the line at once. On a network each chunk becomes a packet, and most frames should fit into one.
#if !defined(__AVR__)
  typedef uint16_t chunk_length;
  static const chunk_length CHUNK_BYTES = 1024;
#elif defined(ROSSERIAL_ARDUINO_TCP) || defined(ROSSERIAL_ARDUINO_UDP)
  typedef uint8_t chunk_length;
  static const chunk_length CHUNK_BYTES = 240;
#else
  typedef uint8_t chunk_length;
  static const chunk_length CHUNK_BYTES = 64;
#endif

  ROS_NOINLINE FrameWriter(FrameSink& sink, uint16_t topic_id, uint16_t length)
      : sink_(sink), to_(chunk_ + FRAME_HEADER_BYTES), room_(CHUNK_BYTES - FRAME_HEADER_BYTES), sending_(true) {
    chunk_[0] = FRAME_SYNC;
    chunk_[1] = FRAME_VERSION;
    chunk_[2] = static_cast<uint8_t>(length);
    chunk_[3] = static_cast<uint8_t>(length >> 8);
    chunk_[4] = static_cast<uint8_t>(255 - (chunk_[2] + chunk_[3]));
    chunk_[5] = static_cast<uint8_t>(topic_id);
    chunk_[6] = static_cast<uint8_t>(topic_id >> 8);
    sum_ = static_cast<uint8_t>(chunk_[5] + chunk_[6]);
  }

  ROS_NOINLINE void put(const void* bytes, size_t count) {
    if (count > room_) return putAcross(bytes, count);
    chunk_length left = static_cast<chunk_length>(count);
    room_ = static_cast<chunk_length>(room_ - left);
    const uint8_t* from = static_cast<const uint8_t*>(bytes);
    uint8_t* to = to_;
    uint8_t sum = sum_;
    if (left == 0) return;
    do {
      const uint8_t byte = *from++;
      sum = static_cast<uint8_t>(sum + byte);
      *to++ = byte;
    } while (--left);
    sum_ = sum;
    to_ = to;
  }
  ROS_NOINLINE void widen(const void* floats, size_t bytes) {
    const uint8_t* from = static_cast<const uint8_t*>(floats);
    for (const uint8_t* end = from + bytes; from != end; from += 4) {
      if (room_ < 8) flush();
      uint8_t* to = to_;
      widenFloat(from, to);
      sum_ = static_cast<uint8_t>(sum_ + to[3] + to[4] + to[5] + to[6] + to[7]);
      to_ = to + 8;
      room_ = static_cast<chunk_length>(room_ - 8);
    }
  }
  // The four bytes before a string or an array.
  ROS_NOINLINE void count(size_t length) {
    const uint32_t prefix = static_cast<uint32_t>(length);
    put(&prefix, 4);
  }
  ROS_NOINLINE void string(const char* text) {
    const size_t length = text ? strlen(text) : 0;
    count(length);
    put(text, length);
  }
  ROS_NOINLINE void string(FlashText text) {
    count(ROS_FLASH_LENGTH(text.address));
    for (;; ++text.address) {
      const uint8_t byte = static_cast<uint8_t>(ROS_READ_FLASH(text.address));
      if (byte == 0) return;
      put(&byte, 1);
    }
  }

  // Ends the frame; false if the line did not take all of it.
  ROS_NOINLINE bool finish() {
    const uint8_t check = static_cast<uint8_t>(255 - sum_);
    put(&check, 1);
    flush();
    return sending_;
  }

 private:
  // What does not fit into the rest of the chunk. Apart from `put`, which mostly does without the registers that this needs.
  ROS_NOINLINE void putAcross(const void* bytes, size_t count) {
    const size_t part = room_;
    put(bytes, part);
    flush();
    put(static_cast<const uint8_t*>(bytes) + part, count - part);
  }
  ROS_NOINLINE void flush() {
    if (sending_) sending_ = sink_.transmit(chunk_, static_cast<uint16_t>(to_ - chunk_));
    to_ = chunk_;
    room_ = CHUNK_BYTES;
  }

  FrameSink& sink_;
  uint8_t* to_;
  chunk_length room_;
  uint8_t sum_;
  bool sending_;
  uint8_t chunk_[CHUNK_BYTES];
};

}  // namespace ros

#endif
