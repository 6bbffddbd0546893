// Receives the commands for one robot of a fleet from a multicast group. The sender is rostether's multicast bridge, or
// the command `rostether fleet drive`.
//
//   #include <Ethernet.h>
//   #include <EthernetUdp.h>
//   #include <ros/multicast_command.h>
//   #include <arduino_control/ArduinoControl.h>
//
//   void drive(const arduino_control::ArduinoControl& command) { ... }
//   void halt() { ... }
//   const ros::FleetKey KEY ROS_FLASH("000102030405060708090a0b0c0d0e0f");
//   ros::MulticastCommand<arduino_control::ArduinoControl, EthernetUDP> commands(&drive, &halt, KEY);
//   ...
//   commands.setRobot(3);
//   commands.begin(IPAddress(239, 255, 82, 83), 11412);
//   ...
//   commands.spinOnce();
//
// The second type is EthernetUDP for a W5100 or W5500, WiFiUDP for Wi-Fi, or any class with Arduino's UDP interface.
// spinOnce calls `halt` when a sender demands it, and when the time to live of the last command has passed. So loop()
// must not block for long. A network chip may block while it searches for the sender's address: limit this with
// Ethernet.setRetransmissionTimeout.
#ifndef ROS_MULTICAST_COMMAND_H_
#define ROS_MULTICAST_COMMAND_H_

#include <Arduino.h>
#include <stddef.h>
#include <stdint.h>

#include "ros/command_receiver.h"
#include "ros/flash.h"
#include "ros/message.h"
#include "ros/multicast_socket.h"

namespace ros {

// Computes the kind of a message type: the first four bytes of its MD5 sum, in the byte order of a frame.
struct CommandKind {
  constexpr explicit CommandKind(const char* md5) : value(word(md5, 4)) {}
  const uint32_t value;

 private:
  static constexpr uint32_t word(const char* hex, uint8_t bytes) {
    return bytes ? static_cast<uint32_t>(digit(hex[0]) << 4 | digit(hex[1])) | word(hex + 2, static_cast<uint8_t>(bytes - 1)) << 8 : 0;
  }
  static constexpr uint8_t digit(char c) { return static_cast<uint8_t>(c <= '9' ? c - '0' : c - 'a' + 10); }
};

// M is a generated message of at most PAYLOAD_BYTES.
template <class M, class NetworkUdp, uint16_t PAYLOAD_BYTES = 64>
class MulticastCommand {
 public:
  typedef void (*Drive)(const M&);
  typedef void (*Halt)();

  // The key stays in program memory. The default key is all zeros: then tags detect damage, but not forgery.
  MulticastCommand(Drive drive, Halt halt, const FleetKey& key = FleetKey::none())
      : drive_(drive), halt_(halt), receiver_(key, KIND) {}

  // Sets the id of this robot, and the mask of its groups: bit N is group N. It obeys commands to its id and to its
  // groups. The default is robot 1 of group 0.
  void setRobot(uint32_t id, uint32_t groups = 1) { receiver_.setRobot(id, groups); }

  // Sets the strength of the radio's signal in dBm that statuses report.
  void setSignal(int8_t dbm) { receiver_.setSignal(dbm); }

  // Stops the robot and joins the group. The network must be up.
  void begin(const IPAddress& group, uint16_t port) {
    halt_();
    socket_.begin(static_cast<uint32_t>(group), port);
  }

  // Handles received commands, and halts when the time to live has passed. Call it in each loop().
  void spinOnce() {
    MulticastCommand* self = this;
    ROS_CONCEAL(self);
    self->spin();
  }

  bool isMoving() const { return receiver_.isMoving(); }

 private:
  // The limit for one call, so that it ends: more datagrams wait for the next call.
  static const uint8_t MAX_DATAGRAMS = 8;
  static const size_t COMMAND_BYTES = CommandReceiver::FRAME_BYTES + PAYLOAD_BYTES;
  static const size_t STATUS_BYTES = CommandReceiver::STATUS_BYTES;
  static const size_t BUFFER_BYTES = COMMAND_BYTES > STATUS_BYTES ? COMMAND_BYTES : STATUS_BYTES;
  static const uint32_t KIND = CommandKind(M::getMD5()).value;

  void spin() {
    uint8_t count = MAX_DATAGRAMS;
    uint16_t now_ms;
    do now_ms = static_cast<uint16_t>(millis());
    while (receiveOne(now_ms) && --count);
    const bool expired = receiver_.expired(now_ms);
    if (expired) halt_();
    socket_.watch(now_ms, expired);
  }

  ROS_APART bool receiveOne(uint16_t now_ms) {
    // Aligned for the message, which is read in place.
    union {
      uint32_t aligned;
      uint8_t bytes[BUFFER_BYTES];
    } buffer;
    uint8_t* const frame = buffer.bytes;
    const int size = socket_.next(now_ms);
    if (size <= 0) return false;
    if (static_cast<size_t>(size) > sizeof buffer) {
      socket_.skip(frame, sizeof buffer.bytes, static_cast<size_t>(size));
      return true;
    }
    socket_.udp().read(frame, static_cast<size_t>(size));
    const uint8_t demand = receiver_.receive(frame, static_cast<uint16_t>(size), now_ms);
    if (demand & CommandReceiver::OBEY) {
      receiver_.setHolder(static_cast<uint32_t>(socket_.udp().remoteIP()), socket_.udp().remotePort());
      obey(frame, static_cast<uint16_t>(size - CommandReceiver::FRAME_BYTES));
    }
    if (demand & CommandReceiver::ANSWER) {
      receiver_.answer(frame);
      socket_.answer(frame, STATUS_BYTES);
    }
    return true;
  }

  ROS_APART void obey(uint8_t* frame, uint16_t length) {
    if (isMoving()) {
      M message;
      uint8_t* const payload = frame + CommandReceiver::HEADER_BYTES;
      if (message.deserialize(payload, length, BUFFER_BYTES - CommandReceiver::HEADER_BYTES) >= 0) return drive_(message);
    }
    halt_();
  }

  MulticastSocket<NetworkUdp> socket_;
  Drive drive_;
  Halt halt_;
  CommandReceiver receiver_;
};

}  // namespace ros

#endif
