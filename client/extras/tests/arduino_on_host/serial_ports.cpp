// Ports of several classes behind ArduinoHardware. Exits with the number of the first check that fails.
#include "../platforms/platform_node.h"

HardwareSerial Serial;

// Like SoftwareSerial, it does not report its room: Print returns 0.
class QuietPort : public Stream {
 public:
  QuietPort() : baud_(0), written_(0) {}
  void begin(long baud) { baud_ = baud; }
  size_t write(uint8_t) { return ++written_, 1; }
  using Print::write;
  int available() { return 0; }
  int read() { return -1; }

  long baud_;
  size_t written_;
};

class TightPort : public QuietPort {
 public:
  int availableForWrite() { return 5; }
};

// A stream without `begin`.
class BareStream : public Stream {
 public:
  size_t write(uint8_t) { return 1; }
  int available() { return 0; }
  int read() { return 'x'; }
};

QuietPort quiet;
TightPort tight;
BareStream bare;

class NewHardware : public ArduinoHardware {
 public:
  NewHardware() : ArduinoHardware(&quiet, 9600) {}
};

// Sets up a port other than Serial with its own init, as sketches do.
class OwnInit : public ArduinoHardware {
 public:
  OwnInit() {
    iostream = &Serial;
    baud_ = 115200;
  }
  void init() { iostream->begin(static_cast<unsigned long>(baud_) * 2); }
};

int main() {
  ArduinoHardware plain;
  if (plain.getBaud() != 57600) return 1;
  plain.init();
  if (Serial.baud_ != 57600 || plain.writable() != 63 || plain.read() != -1) return 2;
  plain.setBaud(1000000);
  if (Serial.baud_ != 57600) return 3;
  plain.init();
  if (Serial.baud_ != 1000000) return 4;

  ArduinoHardware soft(&quiet);
  soft.init();
  if (quiet.baud_ != 57600) return 5;
  // Unknown room does not mean no room: messages are sent.
  if (soft.writable() < 1024) return 6;
  uint8_t bytes[3] = {1, 2, 3};
  soft.write(bytes, 3);
  if (quiet.written_ != 3) return 7;

  plain.setPort(&tight);
  plain.init();
  if (tight.baud_ != 1000000 || plain.writable() != 5) return 8;
  plain.setPort(&bare);
  plain.init();
  if (plain.read() != 'x' || plain.writable() < 1024) return 9;
  plain.setPort(&Serial);
  if (plain.writable() != 63) return 10;

  OwnInit own;
  own.init();
  if (Serial.baud_ != 230400) return 11;

  ros::NodeHandle_<NewHardware> node;
  node.initNode();
  if (quiet.baud_ != 9600) return 12;
  ros::NodeHandle_<ArduinoHardware> other(ArduinoHardware(&quiet, 4800));
  other.getHardware()->setBaud(2400);
  other.initNode();
  if (quiet.baud_ != 2400) return 13;
  return 0;
}
