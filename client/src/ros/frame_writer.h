#ifndef ROS_FRAME_WRITER_H_
#define ROS_FRAME_WRITER_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/flash.h"
#include "ros/float64.h"
#include "ros/inlining.h"
#include "ros/node_state.h"
#include "ros/topic_id.h"

namespace ros {

// Sink that sends a message as a frame: its length is known beforehand, its bytes stream through a small
// chunk, its checksum is summed up on the way. No buffer for the whole of it.
//
// A node sends one frame at a time, so there is one chunk: a frame on the stack would lie there beside all that the line needs.
class FrameWriter : protected NodeState {
 public:
  using NodeState::CHUNK_BYTES;

  ROS_APART void begin(uint16_t topic_id, uint16_t length) {
    chunk_bytes_ = SPARE_BYTES;
    if (SPARE_BYTES != CHUNK_BYTES) {
      const uint16_t lent = window_.lend(CHUNK_BYTES);
      if (lent) chunk_bytes_ = static_cast<chunk_length>(lent);
    }
    uint8_t* to = chunk();
    *to++ = FRAME_SYNC;
    *to++ = FRAME_VERSION;
    const uint8_t low = static_cast<uint8_t>(length), high = static_cast<uint8_t>(length >> 8);
    *to++ = low;
    *to++ = high;
    *to++ = static_cast<uint8_t>(255 - (low + high));
    const uint8_t id_low = static_cast<uint8_t>(topic_id), id_high = static_cast<uint8_t>(topic_id >> 8);
    *to++ = id_low;
    *to++ = id_high;
    to_ = to;
    sum_ = static_cast<uint8_t>(id_low + id_high);
    room_ = static_cast<chunk_length>(chunk_bytes_ - FRAME_HEADER_BYTES);
    sending_ = true;
  }

  void put(const void* bytes, size_t count) { copy(static_cast<const uint8_t*>(bytes), count, false); }
  ROS_APART void widen(const void* floats, size_t bytes) {
    const uint8_t* from = static_cast<const uint8_t*>(floats);
    for (const uint8_t* end = from + bytes; from != end; from += 4) {
      // Not `reserve`, whose call would take a quarter of the time.
      if (room_ < 8) flush();
      uint8_t* to = to_;
      sum_ = static_cast<uint8_t>(sum_ + widenFloat(from, to));
      to_ = to + 8;
      room_ = static_cast<chunk_length>(room_ - 8);
    }
  }
  // The four bytes before a string or an array.
  ROS_APART void count(size_t length) {
    uint8_t* to = reserve(4);
    const uint32_t prefix = static_cast<uint32_t>(length);
    const uint8_t bytes[] = {static_cast<uint8_t>(prefix), static_cast<uint8_t>(prefix >> 8),
                             static_cast<uint8_t>(prefix >> 16), static_cast<uint8_t>(prefix >> 24)};
    to[0] = bytes[0];
    to[1] = bytes[1];
    to[2] = bytes[2];
    to[3] = bytes[3];
    sum_ = static_cast<uint8_t>(sum_ + bytes[0] + bytes[1] + bytes[2] + bytes[3]);
  }
  ROS_APART void string(const char* text) {
    const size_t length = text ? strlen(text) : 0;
    count(length);
    put(text, length);
  }
  void string(FlashText text) { flashString(text.address, ROS_FLASH_LENGTH(text.address)); }
  // The same for a text whose length is known.
  ROS_APART void flashString(const char* address, size_t length) {
    count(length);
    copy(reinterpret_cast<const uint8_t*>(address), length, true);
  }
  ROS_APART void byte(uint8_t byte) {
    *reserve(1) = byte;
    sum_ = static_cast<uint8_t>(sum_ + byte);
  }

  void word(uint16_t word) {
    byte(static_cast<uint8_t>(word));
    byte(static_cast<uint8_t>(word >> 8));
  }

  // Ends the frame; false if the line did not take all of it.
  ROS_APART bool finish() {
    byte(static_cast<uint8_t>(255 - sum_));
    flush();
    if (chunk_bytes_ != SPARE_BYTES) window_.takeBack(chunk_bytes_);
    return sending_;
  }

 protected:
  FrameWriter() : NodeState() {}
  ~FrameWriter() {}

 private:
  // Room for `count` bytes of the chunk, at most 8, for the caller to fill.
  uint8_t* reserve(uint8_t count) {
    if (room_ < count) flush();
    uint8_t* to = to_;
    to_ = to + count;
    room_ = static_cast<chunk_length>(room_ - count);
    return to;
  }
  ROS_APART void copy(const uint8_t* from, size_t count, bool is_in_flash) {
    while (count) {
      if (!room_) flush();
      chunk_length part = room_;
      if (part > count) part = static_cast<chunk_length>(count);
      count -= part;
      room_ = static_cast<chunk_length>(room_ - part);
      uint8_t* to = to_;
      uint8_t sum = sum_;
      if (is_in_flash) {
        do {
          const uint8_t byte = static_cast<uint8_t>(ROS_READ_FLASH(from));
          ++from;
          sum = static_cast<uint8_t>(sum + byte);
          *to++ = byte;
        } while (--part);
      } else {
        do {
          const uint8_t byte = *from++;
          sum = static_cast<uint8_t>(sum + byte);
          *to++ = byte;
        } while (--part);
      }
      sum_ = sum;
      to_ = to;
    }
  }
  uint8_t* chunk() { return chunk_bytes_ != SPARE_BYTES ? window_.lentRoom() : spare_; }
  // In node_handle_base.h: no table of virtual functions for this class, which an AVR would keep in RAM.
  void flush();
};

}  // namespace ros

#endif
