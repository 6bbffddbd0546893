// The controller's side of a bus of DYNAMIXEL servos (protocol 2.0).
//
//   dynamixel::Bus<MyPort> bus(port);
//   bus.write(1, dynamixel::TORQUE_ENABLE, 1, 1);
//   const uint8_t ids[] = {1, 2};
//   const int32_t speeds[] = {100, -100};
//   bus.syncWrite(dynamixel::GOAL_VELOCITY, 4, ids, speeds, 2);
//
// A port has four functions:
//   void write(const uint8_t* bytes, size_t size)   sends, and returns when the servos may answer (half duplex)
//   int read()                                      returns a received byte, or -1 if there is none
//   uint32_t microseconds()                         reads a clock
//   void idle()                                     is called while there is nothing to read
#ifndef DYNAMIXEL_BUS_H_
#define DYNAMIXEL_BUS_H_

#include "dynamixel/packet.h"

namespace dynamixel {

enum Result : uint8_t {
  DONE,       // not OK, which is a macro of the OpenCR's core
  NO_ANSWER,  // the servo did not answer in time
  DAMAGED,    // data arrived, but no undamaged packet
  REFUSED,    // the servo reported an error: `error()`
  TOO_LONG    // the packet does not fit in PACKET_BYTES
};

template <class Port, size_t PACKET_BYTES = 64>
class Bus {
 public:
  // With factory settings, a servo answers 0.5 ms after a request. `timeout_us` is the longest silence.
  explicit Bus(Port& port, uint32_t timeout_us = 5000) : port_(port), timeout_us_(timeout_us), error_(0) {}

  // The error of the last status packet: a ServoError, with ALERT for a hardware error.
  uint8_t error() const { return error_; }
  // The number of damaged packets received since the start.
  uint16_t damaged() const { return reader_.damaged(); }

  // Finds a servo and reads its model: 1060 is an XL430.
  Result ping(uint8_t id, uint16_t& model) {
    writer_.begin(id, PING);
    uint8_t answer[3];
    const Result result = ask(id, answer, sizeof answer);
    if (result == DONE) model = static_cast<uint16_t>(answer[0] | answer[1] << 8);
    return result;
  }

  // Writes a number of 1, 2 or 4 bytes.
  Result write(uint8_t id, uint16_t address, int32_t value, uint8_t size) {
    writer_.begin(id, WRITE);
    writer_.add16(address);
    writer_.addNumber(static_cast<uint32_t>(value), size);
    return ask(id, 0, 0);
  }

  Result read(uint8_t id, uint16_t address, uint8_t* bytes, uint16_t size) {
    writer_.begin(id, READ);
    writer_.add16(address);
    writer_.add16(size);
    return ask(id, bytes, size);
  }

  // Restarts a servo, which clears its hardware error. The servo then does not answer for about 0.2 s.
  Result reboot(uint8_t id) {
    writer_.begin(id, REBOOT);
    return ask(id, 0, 0);
  }

  // Writes numbers to several servos with one packet, which the servos do not answer.
  Result syncWrite(uint16_t address, uint8_t size, const uint8_t* ids, const int32_t* values, uint8_t count) {
    writer_.begin(BROADCAST_ID, SYNC_WRITE);
    writer_.add16(address);
    writer_.add16(size);
    for (uint8_t i = 0; i < count; ++i) {
      writer_.add(ids[i]);
      writer_.addNumber(static_cast<uint32_t>(values[i]), size);
    }
    return send() ? DONE : TOO_LONG;
  }

  // Reads `size` bytes of each servo into `bytes`, in the order of `ids`. Stops at the first servo that fails and
  // returns its result: the bytes of this servo and of those after it are not valid.
  Result syncRead(uint16_t address, uint16_t size, const uint8_t* ids, uint8_t* bytes, uint8_t count) {
    writer_.begin(BROADCAST_ID, SYNC_READ);
    writer_.add16(address);
    writer_.add16(size);
    for (uint8_t i = 0; i < count; ++i) writer_.add(ids[i]);
    if (!send()) return TOO_LONG;
    for (uint8_t i = 0; i < count; ++i) {
      const Result result = receive(ids[i], bytes + i * size, size);
      if (result != DONE) return result;
    }
    return DONE;
  }

 private:
  // Limits for a line that never pauses. The first is more than any driver buffers; the second is more than an echoed
  // request, its answer and some noise.
  static const uint16_t MAX_WAITING_BYTES = 4096;
  static const size_t MAX_ANSWER_BYTES = 4 * PACKET_BYTES;

  bool send() {
    if (!writer_.finish()) return false;
    // A late answer to an earlier request is not the answer to this one.
    for (uint16_t left = MAX_WAITING_BYTES; left > 0 && port_.read() >= 0; --left) {
    }
    reader_.restart();
    port_.write(writer_.bytes(), writer_.size());
    return true;
  }

  Result ask(uint8_t id, uint8_t* bytes, size_t size) { return send() ? receive(id, bytes, size) : TOO_LONG; }

  Result receive(uint8_t id, uint8_t* bytes, size_t size) {
    const uint16_t damaged = reader_.damaged();
    uint32_t heard_us = port_.microseconds();
    size_t left = MAX_ANSWER_BYTES;
    while (port_.microseconds() - heard_us < timeout_us_) {
      const int byte = port_.read();
      if (byte < 0) {
        port_.idle();
        continue;
      }
      if (left-- == 0) return DAMAGED;
      heard_us = port_.microseconds();
      if (!reader_.push(static_cast<uint8_t>(byte))) continue;
      // On a bus with one wire, the request itself may also be received.
      if (reader_.instruction() != STATUS || reader_.id() != id || reader_.size() == 0) continue;
      error_ = reader_.parameters()[0];
      if (error_ & ~ALERT) return REFUSED;
      if (reader_.size() != size + 1) return DAMAGED;
      for (size_t i = 0; i < size; ++i) bytes[i] = reader_.parameters()[1 + i];
      return DONE;
    }
    return reader_.damaged() != damaged ? DAMAGED : NO_ANSWER;
  }

  Port& port_;
  const uint32_t timeout_us_;
  uint8_t error_;
  PacketWriter<PACKET_BYTES> writer_;
  PacketReader<PACKET_BYTES> reader_;
};

// Convert received bytes, little endian, to a number.
inline int32_t toInt32(const uint8_t* bytes) {
  return static_cast<int32_t>(static_cast<uint32_t>(bytes[0]) | static_cast<uint32_t>(bytes[1]) << 8 |
                              static_cast<uint32_t>(bytes[2]) << 16 | static_cast<uint32_t>(bytes[3]) << 24);
}
inline int16_t toInt16(const uint8_t* bytes) { return static_cast<int16_t>(bytes[0] | bytes[1] << 8); }

}  // namespace dynamixel

#endif
