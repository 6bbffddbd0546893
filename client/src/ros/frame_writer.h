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

// A sink that sends a message as a frame. It gets the length in advance, and collects bytes in a small chunk that it
// adds to the checksum and sends when it is full. So no buffer for the whole message is needed.
//
// A node sends one frame at a time, so there is one chunk. On the stack, it would need memory in addition to that of
// the line's functions.
class FrameWriter : protected NodeState {
 public:
  using NodeState::CHUNK_BYTES;
  uint32_t time() override ROS_ABSTRACT;

  ROS_APART void begin(uint16_t topic_id, uint16_t length) {
    uint8_t* to = spare_;
    chunk_bytes_ = SPARE_BYTES;
    if (SPARE_BYTES != CHUNK_BYTES) {
      const uint16_t lent = window_.lend(CHUNK_BYTES);
      if (lent) {
        chunk_bytes_ = static_cast<chunk_length>(lent);
        to = window_.lentRoom();
      }
    }
    to_ = to + FRAME_HEADER_BYTES;
    sum_ = static_cast<uint8_t>(topic_id + (topic_id >> 8));
    room_ = static_cast<chunk_length>(chunk_bytes_ - FRAME_HEADER_BYTES);
    sending_ = true;
    writeHeader(to, topic_id, length);
  }

  void put(const void* bytes, size_t count) { copy(static_cast<const uint8_t*>(bytes), count, false); }
  // Like put, for bytes in flash.
  void putFlash(const char* address, size_t count) { copy(reinterpret_cast<const uint8_t*>(address), count, true); }
  ROS_APART void widen(const void* floats, size_t bytes) {
    const uint8_t* from = static_cast<const uint8_t*>(floats);
    for (const uint8_t* end = from + bytes; from != end; from += 4) {
      if (room_ < 8 + MIN_ROOM_BYTES) flush();
      uint8_t* to = to_;
      sum_ = static_cast<uint8_t>(sum_ + widenFloat(from, to));
      to_ = to + 8;
      room_ = static_cast<chunk_length>(room_ - 8);
    }
  }
  // Writes the four bytes of the length before a string or an array.
  ROS_APART void count(size_t length) {
    uint8_t* to = to_;
    to_ = to + 4;
    // Always zero on a processor with 16-bit addresses.
    const uint16_t upper = static_cast<uint16_t>(static_cast<uint32_t>(length) >> 16);
    const uint8_t bytes[] = {static_cast<uint8_t>(length), static_cast<uint8_t>(length >> 8), static_cast<uint8_t>(upper),
                             static_cast<uint8_t>(upper >> 8)};
    to[0] = bytes[0];
    to[1] = bytes[1];
    to[2] = bytes[2];
    to[3] = bytes[3];
    sum_ = static_cast<uint8_t>(sum_ + bytes[0] + bytes[1] + bytes[2] + bytes[3]);
    room_ = static_cast<chunk_length>(room_ - 4);
    if (room_ < MIN_ROOM_BYTES) flush();
  }
  ROS_APART void string(const char* text) {
    const size_t length = text ? strlen(text) : 0;
    count(length);
    put(text, length);
  }
  void string(FlashText text) {
    const size_t length = ROS_FLASH_LENGTH(text.address);
    count(length);
    putFlash(text.address, length);
  }
  ROS_APART void byte(uint8_t byte) {
    *to_++ = byte;
    sum_ = static_cast<uint8_t>(sum_ + byte);
    if (--room_ < MIN_ROOM_BYTES) flush();
  }

  ROS_APART void word(uint16_t word) {
    byte(static_cast<uint8_t>(word));
    byte(static_cast<uint8_t>(word >> 8));
  }

  // Ends the frame. Returns false if the line did not accept all of it.
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
  // There is always room for a count: a flush before a count would need more instructions than one after it.
  static const uint8_t MIN_ROOM_BYTES = 4;

  // A separate function, so that an AVR has the right register for `to`.
  static ROS_APART void writeHeader(uint8_t* to, uint16_t topic_id, uint16_t length) {
    const uint8_t low = static_cast<uint8_t>(length), high = static_cast<uint8_t>(length >> 8);
    to[0] = FRAME_SYNC;
    to[1] = FRAME_VERSION;
    to[2] = low;
    to[3] = high;
    to[4] = static_cast<uint8_t>(255 - (low + high));
    to[5] = static_cast<uint8_t>(topic_id);
    to[6] = static_cast<uint8_t>(topic_id >> 8);
  }
  ROS_APART void copy(const uint8_t* from, size_t count, bool is_in_flash) {
    while (count) {
      chunk_length part = room_;
      if (part > count) part = static_cast<chunk_length>(count);
      count -= part;
      room_ = static_cast<chunk_length>(room_ - part);
      uint8_t* to = to_;
      uint8_t sum = sum_;
      do {
        uint8_t byte;
        if (is_in_flash) {
          byte = static_cast<uint8_t>(ROS_READ_FLASH(from));
        } else {
          byte = *from;
        }
        ++from;
        sum = static_cast<uint8_t>(sum + byte);
        *to++ = byte;
      } while (--part);
      sum_ = sum;
      to_ = to;
      if (room_ < MIN_ROOM_BYTES) flush();
    }
  }
  // Defined in node_handle_base.h: a table of virtual functions for this class would need RAM on an AVR.
  void flush();
};

}  // namespace ros

#endif
