#ifndef ROS_NODE_STATE_H_
#define ROS_NODE_STATE_H_

#include <stdint.h>

#include "ros/clock.h"
#include "ros/inlining.h"
#include "ros/reader.h"
#include "ros/receive_window.h"

#if defined(__AVR__) && !defined(ROS_SMALL_MEMORY)
#define ROS_SMALL_MEMORY
#endif

namespace ros {

class Endpoint;

// The state of a node. It has no constructors, so that one loop can set it to zero: constructors would need 80 bytes
// of code on an AVR. The most used fields come first, because an AVR reaches the first 63 bytes of an object with
// short instructions. The virtual functions are in this class so that `this` is the same address in all classes of a
// node.
struct NodeState {
// The size of the largest chunk, which is written at once. On a network, each chunk becomes a packet, and most frames
// should fit in one.
#if defined(ROS_SMALL_MEMORY)
  // The receive window lends memory for a chunk. If it cannot, these bytes are enough for a double and a count.
  typedef uint8_t chunk_length;
  static const chunk_length SPARE_BYTES = 12;
#if defined(ROSSERIAL_ARDUINO_TCP) || defined(ROSSERIAL_ARDUINO_UDP)
  static const chunk_length CHUNK_BYTES = 240;
#else
  static const chunk_length CHUNK_BYTES = 64;
#endif
#else
  typedef uint16_t chunk_length;
  static const chunk_length SPARE_BYTES = 1024;
  static const chunk_length CHUNK_BYTES = SPARE_BYTES;
#endif

  // Sends bytes. Returns false once the line accepts no more bytes; then the rest of the frame is lost.
  virtual bool transmit(uint8_t* bytes, uint16_t count) = 0;
  // The board's clock in milliseconds.
  virtual uint32_t time() ROS_ABSTRACT;

  // The frame that is being sent.
  uint8_t* to_;
  chunk_length room_;
  chunk_length chunk_bytes_;
  uint8_t sum_;
  bool sending_;
  // The received frame.
  ReceiveWindow window_;
  // A message is read completely before its callback sends another, so the reader and the chunk share memory.
  union {
    Reader reader_;
    uint8_t spare_[SPARE_BYTES];
  };
  uint16_t spin_timeout_ms_;
  uint16_t requested_ms_;
  uint16_t received_ms_;
  uint8_t unanswered_;
  uint8_t depth_;
  uint8_t due_;
  bool connected_;
  bool awaiting_time_;
  bool stalled_;
  Endpoint* endpoints_;
  uint16_t user_topics_;
  Clock clock_;
};

}  // namespace ros

#endif
