// Receives the messages of a topic from a multicast group, in datagrams without frames. The sender is rostether's
// multicast bridge without `_framed`, or the original multicast_topic_bridge.
//
//   ros::MulticastTopic<arduino_control::ArduinoControl, EthernetUDP> commands(&drive, &halt);
//   ...
//   commands.begin(IPAddress(224, 0, 1, 1), 12345);
//   ...
//   commands.spinOnce();
//
// Every machine on the network can send such datagrams. Use ros::MulticastCommand where you can.
#ifndef ROS_MULTICAST_TOPIC_H_
#define ROS_MULTICAST_TOPIC_H_

#include <Arduino.h>
#include <stddef.h>
#include <stdint.h>

#include "ros/message.h"
#include "ros/multicast_socket.h"

namespace ros {

// M is a generated message of at most PAYLOAD_BYTES. `halt` is called after `timeout_ms` without a message.
template <class M, class NetworkUdp, uint16_t PAYLOAD_BYTES = 64>
class MulticastTopic {
 public:
  typedef void (*Drive)(const M&);
  typedef void (*Halt)();

  MulticastTopic(Drive drive, Halt halt, uint16_t timeout_ms = 500)
      : drive_(drive), halt_(halt), timeout_ms_(timeout_ms), obeyed_ms_(0), moving_(false) {}

  // Stops the robot and joins the group. The network must be up.
  void begin(const IPAddress& group, uint16_t port) {
    halt_();
    socket_.begin(static_cast<uint32_t>(group), port);
  }

  // Handles received messages, and halts after the timeout. Call it in each loop().
  void spinOnce() {
    uint8_t count = MAX_DATAGRAMS;
    uint16_t now_ms;
    do now_ms = static_cast<uint16_t>(millis());
    while (receiveOne(now_ms) && --count);
    const bool expired = moving_ && static_cast<uint16_t>(now_ms - obeyed_ms_) >= timeout_ms_;
    if (expired) {
      moving_ = false;
      halt_();
    }
    socket_.watch(now_ms, expired);
  }

  bool isMoving() const { return moving_; }

 private:
  // The limit for one call, so that it ends: more datagrams wait for the next call.
  static const uint8_t MAX_DATAGRAMS = 8;

  bool receiveOne(uint16_t now_ms) {
    // Aligned for the message, which is read in place.
    union {
      uint32_t aligned;
      uint8_t bytes[PAYLOAD_BYTES];
    } buffer;
    const int size = socket_.next(now_ms);
    if (size <= 0) return false;
    const size_t length = static_cast<size_t>(size);
    if (length > sizeof buffer.bytes) {
      socket_.skip(buffer.bytes, sizeof buffer.bytes, length);
      return true;
    }
    socket_.udp().read(buffer.bytes, length);
    M message;
    if (message.deserialize(buffer.bytes, length, sizeof buffer.bytes) < 0) return true;
    obeyed_ms_ = now_ms;
    moving_ = true;
    drive_(message);
    return true;
  }

  MulticastSocket<NetworkUdp> socket_;
  Drive drive_;
  Halt halt_;
  uint16_t timeout_ms_;
  uint16_t obeyed_ms_;
  bool moving_;
};

}  // namespace ros

#endif
