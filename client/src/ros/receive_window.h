// The received bytes that are still needed, with the next frame at their start.
//
//     start     base        begin                 end             limit      capacity
//       | frames in callbacks | candidate | backlog |  room to read  | arrays of the frames
//                             |                                      | in callbacks
//
// Bytes are appended at `end_`. A frame is only accepted as a whole: if its length, its checksum or its duration is
// wrong, one byte is dropped and the rest is examined again, so that a valid frame after or inside an invalid one is
// found. While a callback runs, its frame stays below `base_`; a spinOnce inside the callback (a parameter or service
// call) reads above it.
#ifndef ROS_RECEIVE_WINDOW_H_
#define ROS_RECEIVE_WINDOW_H_

#include <stdint.h>
#include <string.h>

#include "ros/inlining.h"
#include "ros/reader.h"
#include "ros/topic_id.h"

namespace ros {

// A window that is not yet open accepts no bytes: all its members are zero.
class ReceiveWindow {
 public:
  void open(uint8_t* bytes, uint16_t capacity) {
    base_ = bytes;
    limit_ = bytes + capacity;
    largest_payload_ = static_cast<uint16_t>(capacity - FRAME_OVERHEAD_BYTES);
    forget();
  }

  bool empty() const { return begin_ == end_; }
  uint16_t largestPayload() const { return largest_payload_; }
  // Whether `examine` needs more bytes.
  bool wantsMore() const { return end_ != goal_; }
  void append(uint8_t byte) { *end_++ = byte; }
  // Appends the available bytes, up to the wanted number; returns whether there were any.
  template <class Hardware>
  bool fill(Hardware& hardware) {
    uint8_t* end = end_;
    const uint8_t* const goal = goal_;
    while (end != goal) {
      const int byte = hardware.read();
      if (byte < 0) break;
      *end++ = static_cast<uint8_t>(byte);
    }
    const bool received = end != end_;
    end_ = end;
    return received;
  }
  // Whether there is room for bytes that are read before they are needed.
  bool room() { return end_ != limit_ || compact(); }
  void appendBacklog(uint8_t byte) {
    append(byte);
    goal_ = end_;
  }

  enum Finding {
    NOTHING_WHOLE = 0,
    NOISE_BEFORE_FRAME = 1,  // bytes that were not a frame, and are dropped
    WHOLE_FRAME = 2          // a whole, undamaged frame is at the front
  };
  // Examines the received bytes: drops those that are not a frame, until the next frame is at the front.
  ROS_APART uint8_t examine() {
    uint8_t found = NOTHING_WHOLE;
    while (begin_ != end_) {
      const uint16_t wanted = judge();
      if (wanted <= have()) {
        if (wanted) return WHOLE_FRAME;
      } else {
        // Inside a callback, there may be too little room for this frame. Then it is dropped, because the response that
        // the callback waits for may follow.
        if (wanted > space()) compact();
        if (wanted <= space()) {
          goal_ = begin_ + wanted;
          return found;
        }
      }
      drop();
      found = NOISE_BEFORE_FRAME;
    }
    forget();
    return found;
  }

  // Whether the bytes dropped since the last call contained the start of a frame of another protocol version.
  bool readAndClearForeign() {
    const bool foreign = is_foreign_;
    is_foreign_ = false;
    return foreign;
  }

  // Drops the first byte.
  ROS_NOINLINE void drop() {
    if (*begin_++ == FRAME_SYNC) countDropped();
  }
  // Drops the incomplete frame at the front.
  void giveUp() {
    drop();
    goal_ = end_;
  }
  // Drops all bytes.
  void forget() {
    begin_ = end_ = goal_ = base_;
    if (space() >= FIRST_LOOK_BYTES) goal_ += FIRST_LOOK_BYTES;
  }
  ROS_NOINLINE void countDropped() { ++dropped_; }
  // The number (modulo 65536) of frames that started and were dropped, and of messages that were not sent.
  uint16_t dropped() const { return dropped_; }

  // Lends memory below the limit for bytes to send, and returns its size: at most `wanted` and at most half of the free
  // memory, so that bytes can still be received. Returns 0 if there is too little, or if the data of the last message
  // may be there.
  uint16_t lend(uint16_t wanted) {
    uint16_t room = static_cast<uint16_t>(limit_ - end_) / 2;
    if (room < MIN_LENT_BYTES || held_) return 0;
    if (room > wanted) room = wanted;
    limit_ -= room;
    return room;
  }
  uint8_t* lentRoom() const { return limit_; }
  void takeBack(uint16_t lent) { limit_ += lent; }

  // Keeps the arena of the frame's arrays until the frame is released.
  void keepArena(uint8_t* arena_end) { limit_ = arena_end; }

  // Keeps the bytes of the last frame in place until `release`, even after its callback.
  void hold() { held_ = true; }
  void release() { held_ = false; }
  bool held() const { return held_; }

  // Removes the frame at the front from the window; the destructor frees its bytes.
  class Taken {
   public:
    explicit Taken(ReceiveWindow& window) : window_(window), base_(window.base_), limit_(window.limit_) {
      // Bytes that arrive while the callback sends need room, even if other frames were before this one.
      if (window.begin_ - window.base_ > window.limit_ - window.end_) window.compact();
      frame_ = window.begin_;
      window.begin_ += length() + FRAME_OVERHEAD_BYTES;
      window.base_ = window.begin_;
      window.goal_ = window.end_;
    }
    ~Taken() {
      window_.base_ = base_;
      window_.limit_ = limit_;
    }
    Taken(const Taken&) = delete;
    Taken& operator=(const Taken&) = delete;

    uint16_t id() const { return word(frame_ + 5); }
    uint16_t length() const { return word(frame_ + 2); }
    uint8_t* payload() const { return frame_ + FRAME_HEADER_BYTES; }
    // Opens the reader for the message, with the free memory as arena.
    void read(Reader& reader) const { reader.open(payload(), length(), window_.end_, window_.limit_); }

   private:
    ReceiveWindow& window_;
    uint8_t* frame_;
    uint8_t* base_;
    uint8_t* limit_;
  };

 private:
  // The sync byte and the version byte.
  static const uint8_t FIRST_LOOK_BYTES = 2;
  static const uint8_t MIN_LENT_BYTES = 16;

  static uint16_t word(const uint8_t* bytes) { return static_cast<uint16_t>(bytes[0] | bytes[1] << 8); }
  uint16_t have() const { return static_cast<uint16_t>(end_ - begin_); }
  uint16_t space() const { return static_cast<uint16_t>(limit_ - begin_); }

  // Checks the frame at the front. Returns 0 if the bytes are not a frame, and the frame's length if the frame is
  // complete and undamaged. Otherwise, returns how many bytes the next check needs: more than there are.
  ROS_APART uint16_t judge() {
    const uint8_t* frame = begin_;
    if (frame[0] != FRAME_SYNC) return 0;
    if (have() < FIRST_LOOK_BYTES) return FIRST_LOOK_BYTES;
    if (frame[1] != FRAME_VERSION) {
      is_foreign_ = true;
      return 0;
    }
    if (have() < FRAME_OVERHEAD_BYTES) return FRAME_OVERHEAD_BYTES;
    if (static_cast<uint8_t>(frame[2] + frame[3] + frame[4]) != 0xff) return 0;
    const uint16_t length = word(frame + 2);
    if (length > largest_payload_) return 0;
    const uint16_t whole = length + FRAME_OVERHEAD_BYTES;
    if (have() < whole) return whole;
    uint8_t sum = 0;
    for (const uint8_t* byte = frame + 5; byte != frame + whole; ++byte) sum = static_cast<uint8_t>(sum + *byte);
    return sum == 0xff ? whole : 0;
  }

  // Moves the bytes down to the base. `examine` must then determine again how many are wanted. Returns false if they
  // are already there.
  bool compact() {
    if (begin_ == base_) return false;
    const uint16_t kept = have();
    memmove(base_, begin_, kept);
    begin_ = base_;
    goal_ = end_ = base_ + kept;
    return true;
  }

  uint8_t* begin_;
  uint8_t* end_;
  uint8_t* base_;
  uint8_t* limit_;
  uint8_t* goal_;
  uint16_t largest_payload_;
  uint16_t dropped_;
  bool held_;
  bool is_foreign_;
};

}  // namespace ros

#endif
