// ROBOTIS' remote control RC-100 on the Bluetooth connector. A packet is ff 55, then two bytes of buttons, each with
// its complement.
#ifndef REMOTE_H
#define REMOTE_H

#include <Arduino.h>

class Remote {
 public:
  float forward = 0, turn = 0;  // m/s, rad/s, while a button is held

  void begin() { SerialBT2.begin(57600); }

  // Handles received bytes. Returns whether a packet was received.
  bool update() {
    bool has_come = false;
    while (SerialBT2.available() > 0) has_come = push(static_cast<uint8_t>(SerialBT2.read())) || has_come;
    return has_come;
  }

 private:
  static const uint8_t UP = 1, DOWN = 2, LEFT = 4, RIGHT = 8;

  bool push(uint8_t byte) {
    static const uint8_t header[] = {0xff, 0x55};
    if (count_ < 2 && byte != header[count_]) {
      count_ = byte == 0xff;
      return false;
    }
    packet_[count_++] = byte;
    if (count_ < sizeof packet_) return false;
    count_ = 0;
    if ((packet_[2] ^ packet_[3]) != 0xff || (packet_[4] ^ packet_[5]) != 0xff) return false;
    const uint8_t held = packet_[2];
    forward = held & UP ? 0.15f : held & DOWN ? -0.15f : 0;
    turn = held & LEFT ? 1.0f : held & RIGHT ? -1.0f : 0;
    return true;
  }

  uint8_t packet_[6];
  uint8_t count_ = 0;
};

#endif
