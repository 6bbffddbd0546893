#ifndef ROS_FRAME_WRITER_H_
#define ROS_FRAME_WRITER_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "flash.h"
#include "topic_id.h"
#include "writer.h"

namespace ros {

// Where frames go, a chunk at a time.
class FrameSink {
 public:
  // Hands bytes to the line. False once the line has stopped taking them; the rest of the frame is then lost.
  virtual bool transmit(uint8_t* bytes, uint16_t count) = 0;

 protected:
  ~FrameSink() {}
};

// Archive that sends a message as a frame: its length is known beforehand, its bytes stream through a small
// chunk, its checksum is summed up on the way. No buffer for the whole of it.
class FrameWriter : public Writer<FrameWriter> {
 public:
  FrameWriter(FrameSink& sink, uint16_t topic_id, uint16_t length)
      : sink_(sink), used_(FRAME_HEADER_BYTES), sum_(0), sending_(true) {
    chunk_[0] = FRAME_SYNC;
    chunk_[1] = FRAME_VERSION;
    chunk_[2] = static_cast<uint8_t>(length);
    chunk_[3] = static_cast<uint8_t>(length >> 8);
    chunk_[4] = static_cast<uint8_t>(255 - (chunk_[2] + chunk_[3]));
    chunk_[5] = static_cast<uint8_t>(topic_id);
    chunk_[6] = static_cast<uint8_t>(topic_id >> 8);
    sum_ = static_cast<uint8_t>(chunk_[5] + chunk_[6]);
  }

  void put(const void* bytes, size_t count) {
    const uint8_t* next = static_cast<const uint8_t*>(bytes);
    for (; count; --count) put(*next++);
  }
  void put(uint8_t byte) {
    sum_ += byte;
    if (used_ == sizeof chunk_) flush();
    chunk_[used_++] = byte;
  }
  void string(const char* text) { Writer<FrameWriter>::string(text); }
  void string(FlashText text) {
    const size_t length = ROS_FLASH_LENGTH(text.address);
    count(length);
    for (size_t i = 0; i < length; ++i) put(static_cast<uint8_t>(ROS_READ_FLASH(text.address + i)));
  }

  // Ends the frame; false if the line did not take all of it.
  bool finish() {
    put(static_cast<uint8_t>(255 - sum_));
    flush();
    return sending_;
  }

 private:
  void flush() {
    if (sending_) sending_ = sink_.transmit(chunk_, used_);
    used_ = 0;
  }

  FrameSink& sink_;
#if defined(__AVR__)
  uint8_t used_;
#else
  uint16_t used_;
#endif
  uint8_t sum_;
  bool sending_;
  // On a network each chunk becomes a packet: where memory is no matter, most frames should fit into one.
#if defined(__AVR__)
  uint8_t chunk_[64];
#else
  uint8_t chunk_[1024];
#endif
};

}  // namespace ros

#endif
