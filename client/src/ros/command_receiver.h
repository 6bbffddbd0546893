// The receiver of framed commands in a robot, without network and clock. It obeys one sender at a time, and detects
// when the robot must stop.
//
// A command is one datagram, and so is the status that answers it. Numbers are little endian:
//
//   bytes   command                                             status
//   0-2     "rC", version 1                                     "rS", version 1
//   3       flags                                               1: the robot moves; 2: a sender commands it
//   4-7     a robot's id, or a mask of groups                   the robot's id
//   8-15    epoch: when the sender started                      the same
//   16-19   sequence number: 1 for the epoch's first frame       the same
//   20-21   time to live in milliseconds, from receipt          20-23: frames received from this sender
//   22-23   length of the payload                               24-27: frames of it that were lost
//   24-27   kind: start of the MD5 sum of the payload's type    28: refusal; 29: signal in dBm; 30-31: length of the rest
//   28-     payload                                             32-37: the obeyed sender's IPv4 address and port; 38-45: its epoch
//   last 8  SipHash-2-4 of all bytes before it, under the fleet's key
#ifndef ROS_COMMAND_RECEIVER_H_
#define ROS_COMMAND_RECEIVER_H_

#include <stdint.h>
#include <string.h>

#include "ros/inlining.h"
#include "ros/siphash.h"

namespace ros {

class CommandReceiver {
 public:
  // What to do after a datagram, as bits: obey it, and send a status to its sender.
  enum { NOTHING, OBEY, ANSWER };
  enum { HEADER_BYTES = 28, FRAME_BYTES = HEADER_BYTES + SipHash::TAG_BYTES };
  enum { STATUS_BYTES = 32 + 6 + 8 + SipHash::TAG_BYTES };

  // Starts as robot 1 of group 0. `kind` holds the first four bytes of the MD5 sum of the command type.
  CommandReceiver(const FleetKey& key, uint32_t kind) {
    memset(static_cast<void*>(this), 0, sizeof *this);
    key_ = &key;
    kind_ = kind;
    id_[0] = groups_[0] = 1;
    status_.address_bytes = sizeof status_.ip + sizeof status_.port;
  }

  void setRobot(uint32_t id, uint32_t groups) {
    memcpy(id_, &id, sizeof id_);
    memcpy(groups_, &groups, sizeof groups_);
  }
  void setSignal(int8_t dbm) { status_.signal_dbm = dbm; }
  bool isMoving() const { return state_ == MOVING; }

  // Returns true, once, when the robot must stop because the time to live of the sender's last command has passed. Call
  // it at least twice a minute.
  bool expired(uint16_t now_ms) {
    if (state_ == FREE || static_cast<int16_t>(now_ms - deadline_ms_) < 0) return false;
    const bool was_moving = isMoving();
    state_ = FREE;
    return was_moving;
  }

  // Handles a datagram: overwrites its header and tag, and returns what to do. After OBEY, `isMoving` returns whether
  // to move or to stop; pass the address of the sender to `setHolder`.
  uint8_t receive(uint8_t* frame, uint16_t size, uint16_t now_ms) {
    if (!isForMe(frame, size)) return NOTHING;
    // The entry of the sender, or the one to use for a new sender, and the age of the frame compared with this entry.
    Sender* sender = &own_;
    const uint8_t age = compare(frame, sender);
    uint8_t its_age = age;
    if (age != NEXT) {
      sender = others_;
      its_age = compare(frame, sender);
      if (its_age == EARLIER) ++sender;
    }
    if (age == COPY || its_age == COPY) return NOTHING;
    const uint8_t flags = frame[3];
    uint8_t refusal = NONE;
    if (flags & QUERY) refusal = QUERIED;
    // A sender that started earlier is not obeyed again: its frame may be a replay.
    else if (age == EARLIER) refusal = OLDER;
    else if (flags & STOP_ALL) refusal = NONE;
    else if (age == LATER && state_ != FREE) refusal = HELD;
    // Frames that end motion have no payload, and therefore no type.
    else if (flags & ARMED && number(frame + 24) != kind_) refusal = OTHER_TYPE;
    status_.refusal = refusal % QUERIED;
    uint8_t demand = NOTHING;
    if (!refusal) {
      if (age != NEXT) {
        its_age = LATER;
        sender = &own_;
        sender->answered_ms = static_cast<uint16_t>(now_ms - DRIVING_MS);
      }
      uint16_t ttl_ms;
      memcpy(&ttl_ms, frame + 20, sizeof ttl_ms);
      deadline_ms_ = static_cast<uint16_t>(now_ms + ttl_ms);
      uint8_t state = STILL;
      if ((flags & (ARMED | STOP_ALL)) == ARMED) state = MOVING;
      if (flags & RELEASE) state = FREE;
      state_ = state;
      demand = OBEY;
    }
    count(frame, sender, its_age != NEXT);
    if (static_cast<uint16_t>(now_ms - sender->answered_ms) >= (flags & ARMED ? DRIVING_MS : QUICK_MS)) {
      demand |= ANSWER;
      sender->answered_ms = now_ms;
    }
    return demand;
  }

  // The sender of the current command; the first octet of the address is the lowest byte.
  void setHolder(uint32_t ip, uint16_t port) {
    status_.ip = ip;
    status_.port = port;
  }

  // Changes the last datagram into the status for its sender. The status has STATUS_BYTES.
  void answer(uint8_t* frame) const {
    frame[1] = 'S';
    frame[3] = state_;
    memcpy(frame + 4, id_, sizeof id_);
    memcpy(frame + 28, &status_, STATUS_BYTES - 28);
    memcpy(frame + 38, own_.place, EPOCH_BYTES);
    SipHash::combine(key_, frame, STATUS_BYTES - SipHash::TAG_BYTES);
  }

 private:
  enum Flags { ARMED = 1, STOP_ALL = 2, RELEASE = 4, TO_GROUPS = 8, QUERY = 16 };
  enum Refusal { NONE, HELD, OLDER, OTHER_TYPE, QUERIED };
  // The flags of a status: bit 0 is set if the robot moves, bit 1 if a sender commands it.
  enum State { FREE, STILL = 2, MOVING };
  enum Age { COPY, NEXT, EARLIER, LATER };
  // The place of a frame: its epoch and its sequence, which are adjacent.
  enum { PLACE = 8, EPOCH_BYTES = 8, SEQUENCE_BYTES = 4 };
  // The longest time that a robot keeps moving after it loses its sender: a fast robot drives a few meters.
  static const uint16_t LONGEST_TTL_MS = 1000;
  // The shortest time between statuses while the robot drives, and after queries and stops. The latter is shorter,
  // because such a status may be lost.
  static const uint16_t DRIVING_MS = 1000, QUICK_MS = 250;

  struct Sender {
    // The place of the newest frame: a replay of it, or of an earlier one, has no effect.
    uint8_t place[EPOCH_BYTES + SEQUENCE_BYTES];
    // The number of received frames, and the sequence number before the first one.
    uint32_t received;
    uint32_t before;
    // The time of the last status.
    uint16_t answered_ms;
  };
  // The bytes of a status from byte 28 on.
  struct Status {
    uint8_t refusal;
    int8_t signal_dbm;
    uint16_t address_bytes;
    uint32_t ip;
    uint16_t port;
    uint8_t epoch[EPOCH_BYTES];
    uint8_t tag[SipHash::TAG_BYTES];
  };

  // Compares a frame with the newest frame of `sender`. A frame of another epoch is EARLIER or LATER; a frame of the
  // same epoch is NEXT or a COPY.
  ROS_APART static uint8_t compare(const uint8_t* frame, const Sender* sender) {
    const uint8_t* theirs = frame + PLACE + EPOCH_BYTES;
    const uint8_t* newest = sender->place + EPOCH_BYTES;
    uint8_t count = EPOCH_BYTES, age = EARLIER;
    for (;;) {
      do {
        if (*--theirs != *--newest) return static_cast<uint8_t>(age + (*theirs > *newest));
      } while (--count);
      if (!age) return COPY;
      age = COPY;
      count = SEQUENCE_BYTES;
      theirs += EPOCH_BYTES + SEQUENCE_BYTES;
      newest += EPOCH_BYTES + SEQUENCE_BYTES;
    }
  }

  static uint32_t number(const uint8_t* bytes) {
    uint32_t value;
    memcpy(&value, bytes, sizeof value);
    return value;
  }

  // Counts a frame, and writes the numbers of received and lost frames into it, as in a status.
  static void count(uint8_t* frame, Sender* sender, bool first) {
    memcpy(sender->place, frame + PLACE, sizeof sender->place);
    uint32_t received = sender->received;
    if (first) received = 0;
    ++received;
    sender->received = received;
    memcpy(frame + 20, &received, sizeof received);
    uint32_t lost = number(frame + 16) - received;
    if (first) sender->before = lost;
    lost -= sender->before;
    memcpy(frame + 24, &lost, sizeof lost);
  }

  // Whether a frame is for this robot and has a valid tag. With a wrong length, the tag is also invalid.
  bool isForMe(uint8_t* frame, uint16_t size) const {
    if (size < FRAME_BYTES || frame[1] != 'C' || frame[2] != 1) return false;
    uint16_t ttl_ms;
    memcpy(&ttl_ms, frame + 20, sizeof ttl_ms);
    if (static_cast<uint16_t>(ttl_ms - 1) >= LONGEST_TTL_MS) return false;
    const uint32_t target = number(frame + 4);
    if (frame[3] & TO_GROUPS ? !(target & number(groups_)) : target != number(id_)) return false;
    return !SipHash::combine(key_, frame, static_cast<uint16_t>(size - SipHash::TAG_BYTES));
  }

  uint8_t state_;
  uint16_t deadline_ms_;
  const FleetKey* key_;
  // In the byte order of a frame.
  uint8_t id_[4];
  uint8_t groups_[4];
  uint32_t kind_;
  Status status_;
  // The sender that was obeyed last.
  Sender own_;
  // The newest other sender, and the previous one; both only get answers.
  Sender others_[2];
};

}  // namespace ros

#endif
