#ifndef ROS_PLATFORM_RECONNECTION_H_
#define ROS_PLATFORM_RECONNECTION_H_

#include <stdint.h>

namespace ros {

// Decides when the hardware reconnects, and reports it to the node.
class Reconnection {
 public:
  constexpr Reconnection() : tried_ms_(0), pause_ms_(0), connected_(false), changed_(false) {}

  // Whether bytes may be sent and received: the link is connected, and the node knows it (see takeChange).
  bool isOpen() const { return connected_ && !changed_; }
  bool isConnected() const { return connected_; }

  bool isDue(uint32_t now_ms) const { return !connected_ && now_ms - tried_ms_ >= pause_ms_; }

  // Records that an attempt started at `began_ms` and failed at `now_ms`. Pauses double, and are at least as long as
  // the attempt: attempts that block leave half of the time to the sketch.
  void failed(uint32_t began_ms, uint32_t now_ms) {
    const uint32_t took_ms = now_ms - began_ms;
    tried_ms_ = now_ms;
    pause_ms_ = pause_ms_ * 2 < FIRST_PAUSE_MS ? FIRST_PAUSE_MS : pause_ms_ * 2;
    if (pause_ms_ > LONGEST_PAUSE_MS) pause_ms_ = LONGEST_PAUSE_MS;
    if (pause_ms_ < took_ms) pause_ms_ = took_ms < LONGEST_WAIT_MS ? static_cast<uint16_t>(took_ms) : LONGEST_WAIT_MS;
  }
  void succeeded() {
    connected_ = changed_ = true;
    pause_ms_ = 0;
  }
  // Records that the link was lost at `now_ms`. The first attempt to reconnect follows after the shortest pause: a host
  // that closes the link is rarely back immediately.
  void lost(uint32_t now_ms) {
    connected_ = false;
    changed_ = true;
    tried_ms_ = now_ms;
    pause_ms_ = FIRST_PAUSE_MS;
  }
  // Resets the pauses; an attempt is due immediately.
  void reset() {
    connected_ = changed_ = false;
    pause_ms_ = 0;
  }

  // Returns whether the link was lost or made since the last call.
  bool takeChange() {
    const bool changed = changed_;
    changed_ = false;
    return changed;
  }

 private:
  static const uint16_t FIRST_PAUSE_MS = 100;
  // A restarted host is found within a second.
  static const uint16_t LONGEST_PAUSE_MS = 500;
  // Limits the pause after an attempt that blocked for very long, so that the next one follows soon.
  static const uint16_t LONGEST_WAIT_MS = 20000;

  uint32_t tried_ms_;
  uint16_t pause_ms_;
  bool connected_;
  bool changed_;
};

}  // namespace ros

#endif
