// A robot's end of framed commands, without network or clock: obeys one sender at a time, and knows when to stop.
//
// A command, and the status that answers it, in a datagram each. Numbers are little-endian:
//
//   bytes   command                                             status
//   0-2     "rC", version 1                                     "rS", version 1
//   3       flags                                               1: the robot moves
//   4-7     a robot's id, or a mask of groups                   the robot's id
//   8-15    epoch: when the sender started                      the same
//   16-19   sequence: 1 for the first frame of the epoch        the same
//   20-21   time to live in milliseconds, from receipt          20-23: frames received from this sender
//   22-23   length of the payload                               24-27: frames of it that were lost
//   24-27   kind: begin of the MD5 sum of the payload's type    28: refusal; 29: signal in dBm; 30-31: length of the rest
//   28-     payload                                             32-: address of the sender that commands the robot
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
  enum Action { NOTHING, DRIVE, STOP };
  enum { HEADER_BYTES = 28, FRAME_BYTES = HEADER_BYTES + SipHash::TAG_BYTES };
  // With the longest address, 255.255.255.255:65535.
  enum { STATUS_BYTES = 32 + 21 + SipHash::TAG_BYTES };

  // Robot 1 of group 0. `kind` is that of its type of command.
  CommandReceiver(const FleetKey& key, uint32_t kind) {
    memset(static_cast<void*>(this), 0, sizeof *this);
    key_ = &key;
    kind_ = kind;
    setRobot(1, 1);
  }

  void setRobot(uint32_t id, uint32_t groups) {
    id_ = id;
    groups_ = groups;
  }
  void setSignal(int8_t dbm) { signal_dbm_ = dbm; }
  bool isMoving() const { return moving_; }

  // True once when the sender has been silent for its time to live: the robot must stop. To be asked at least once a minute.
  bool expired(uint16_t now_ms) {
    if (!held_ || static_cast<uint16_t>(now_ms - obeyed_ms_) < ttl_ms_) return false;
    held_ = false;
    const bool was_moving = moving_;
    moving_ = false;
    return was_moving;
  }

  // What a datagram demands. The tag is overwritten. If it demands something, tell the sender's address with `setHolder`.
  ROS_APART Action receive(uint8_t* frame, uint16_t size, uint16_t now_ms) {
    answers_ = false;
    if (!isForMe(frame, size)) return NOTHING;
    const uint8_t flags = frame[3];
    const int8_t age = compare(frame + PLACE, own_.place, EPOCH_BYTES);
    const int8_t other_age = compare(frame + PLACE, other_.place, EPOCH_BYTES);
    Sender* sender = &own_;
    if (age) sender = &other_;
    // A copy.
    if ((!age || !other_age) && compare(frame + PLACE + EPOCH_BYTES, sender->place + EPOCH_BYTES, SEQUENCE_BYTES) <= 0)
      return NOTHING;
    if (flags & QUERY) refusal_ = QUERIED;
    // A sender that started earlier is not obeyed again: the frame may be a record.
    else if (age < 0) refusal_ = OLDER;
    else if (flags & STOP_ALL) refusal_ = NONE;
    else if (age && held_) refusal_ = HELD;
    // Frames that end motion have no payload, and so no type.
    else if (flags & ARMED && compare(frame + 24, reinterpret_cast<const uint8_t*>(&kind_), 4)) refusal_ = OTHER_TYPE;
    else refusal_ = NONE;
    if (!refusal_) {
      if (age) {
        sender = &own_;
        received_ = 0;
        memcpy(&first_, frame + PLACE + EPOCH_BYTES, sizeof first_);
        own_.answered_ms = static_cast<uint16_t>(now_ms - DRIVING_MS);
      }
      held_ = !(flags & RELEASE);
      obeyed_ms_ = now_ms;
      memcpy(&ttl_ms_, frame + 20, sizeof ttl_ms_);
      moving_ = (flags & (ARMED | STOP_ALL)) == ARMED;
    }
    if (sender == &own_) ++received_;
    if (sender == &own_ || other_age >= 0) memcpy(sender->place, frame + PLACE, sizeof sender->place);
    if (static_cast<uint16_t>(now_ms - sender->answered_ms) >= (flags & ARMED ? DRIVING_MS : QUICK_MS)) {
      answers_ = true;
      sender->answered_ms = now_ms;
    }
    return refusal_ ? NOTHING : moving_ ? DRIVE : STOP;
  }

  // Where the frame that is obeyed came from; the first octet of the address is the lowest byte.
  void setHolder(uint32_t ip, uint16_t port) {
    holder_ip_ = ip;
    holder_port_ = port;
  }

  // Whether the sender of the last datagram gets a status now.
  bool answers() const { return answers_; }

  // Turns the last datagram's bytes, of which there are STATUS_BYTES, into the status for its sender. Returns the length.
  ROS_APART uint8_t answer(uint8_t* frame) const {
    uint32_t received = 1, lost = 0;
    if (compare(frame + PLACE, own_.place, EPOCH_BYTES) == 0) {
      received = received_;
      memcpy(&lost, frame + PLACE + EPOCH_BYTES, sizeof lost);
      lost += 1 - first_ - received;
    }
    memcpy(frame + 20, &received, sizeof received);
    memcpy(frame + 24, &lost, sizeof lost);
    frame[1] = 'S';
    frame[3] = moving_;
    memcpy(frame + 4, &id_, 4);
    frame[28] = refusal_ % QUERIED;
    frame[29] = static_cast<uint8_t>(signal_dbm_);
    frame[31] = 0;
    uint8_t* end = frame + 32;
    if (held_) {
      const uint8_t* octet = reinterpret_cast<const uint8_t*>(&holder_ip_);
      char mark = '.';
      for (uint8_t i = 0; i < 4; ++i) {
        end = decimal(end, octet[i]);
        if (i == 3) mark = ':';
        *end++ = mark;
      }
      end = decimal(end, holder_port_);
    }
    const uint8_t length = static_cast<uint8_t>(end - frame);
    frame[30] = static_cast<uint8_t>(length - 32);
    SipHash::append(key_, frame, length);
    return static_cast<uint8_t>(length + SipHash::TAG_BYTES);
  }

 private:
  enum Flags { ARMED = 1, STOP_ALL = 2, RELEASE = 4, TO_GROUPS = 8, QUERY = 16 };
  enum Refusal { NONE, HELD, OLDER, OTHER_TYPE, QUERIED };
  // Epoch and sequence, as they are in a frame.
  enum { PLACE = 8, EPOCH_BYTES = 8, SEQUENCE_BYTES = 4 };
  // The longest time that a robot moves after it has lost its sender.
  static const uint16_t LONGEST_TTL_MS = 1000;
  // Between statuses, after commands and after queries and stops, which may get lost.
  static const uint16_t DRIVING_MS = 1000, QUICK_MS = 250;

  // The newest frame: a record of it or of earlier ones has no effect. The time of the last status.
  struct Sender {
    uint8_t place[EPOCH_BYTES + SEQUENCE_BYTES];
    uint16_t answered_ms;
  };

  // Which number is larger: 1 the first, -1 the second.
  ROS_APART static int8_t compare(const uint8_t* first, const uint8_t* second, uint8_t bytes) {
    do {
      --bytes;
      if (first[bytes] != second[bytes]) return first[bytes] > second[bytes] ? 1 : -1;
    } while (bytes);
    return 0;
  }

  ROS_APART static uint8_t* decimal(uint8_t* to, uint16_t value) {
    if (value >= 10) to = decimal(to, value / 10);
    *to++ = static_cast<uint8_t>('0' + value % 10);
    return to;
  }

  // A whole frame with a valid tag, for this robot.
  ROS_APART bool isForMe(uint8_t* frame, uint16_t size) const {
    static const uint8_t MAGIC[] = {'r', 'C', 1};
    if (size < FRAME_BYTES || compare(frame, MAGIC, sizeof MAGIC)) return false;
    uint16_t ttl_ms, length;
    memcpy(&ttl_ms, frame + 20, sizeof ttl_ms);
    memcpy(&length, frame + 22, sizeof length);
    if (static_cast<uint16_t>(ttl_ms - 1) >= LONGEST_TTL_MS || length != size - FRAME_BYTES) return false;
    uint32_t target;
    memcpy(&target, frame + 4, sizeof target);
    if (frame[3] & TO_GROUPS ? !(target & groups_) : target != id_) return false;
    length = static_cast<uint16_t>(size - SipHash::TAG_BYTES);
    uint8_t tag[SipHash::TAG_BYTES];
    memcpy(tag, frame + length, sizeof tag);
    SipHash::append(key_, frame, length);
    uint8_t differing = 0;
    for (uint8_t i = 0; i < sizeof tag; ++i) differing = static_cast<uint8_t>(differing | (tag[i] ^ frame[length + i]));
    return !differing;
  }

  bool answers_;
  // Whether the sender that was obeyed last still commands.
  bool held_;
  bool moving_;
  uint8_t refusal_;
  int8_t signal_dbm_;
  uint16_t obeyed_ms_;
  uint16_t ttl_ms_;
  const FleetKey* key_;
  uint32_t id_;
  uint32_t groups_;
  uint32_t kind_;
  // Of the sender that was obeyed last: its first sequence, and how many frames came since.
  uint32_t first_;
  uint32_t received_;
  uint32_t holder_ip_;
  uint16_t holder_port_;
  // The sender that was obeyed last, and the newest of the others.
  Sender own_;
  Sender other_;
};

}  // namespace ros

#endif
