// Linux (Raspberry Pi and other embedded boards), macOS and other Unixes: a serial port or TCP, chosen by its name.
//
//   nh.initNode("/dev/ttyUSB0")         a path is a serial port
//   nh.initNode("192.168.15.149")       anything else is a host, by default with the port 11411
//   nh.initNode("robot.local:11412")
//   nh.initNode()                       the name in the environment variable ROSSERIAL_PORT, or DEFAULT_PORT
#ifndef ROS_PLATFORM_POSIX_H_
#define ROS_PLATFORM_POSIX_H_

#include <stdlib.h>

#include "ros/platform/posix_tcp.h"
#include "ros/platform/posix_tty.h"

#if !defined(DEFAULT_PORT)
#define DEFAULT_PORT "/dev/ttyAM1"
#endif

namespace ros {

class PosixPipe {
 public:
  PosixPipe() : is_tty_(true) {}

  TtyPipe& tty() { return tty_; }
  void setPort(const char* port) {
    is_tty_ = *port == '/' || *port == '.';
    if (is_tty_) {
      tty_.setPath(port);
    } else {
      tcp_.setAddress(port);
    }
  }

  PipeState open(uint32_t wait_ms) { return is_tty_ ? tty_.open(wait_ms) : tcp_.open(wait_ms); }
  int read(uint8_t* bytes, size_t size) { return is_tty_ ? tty_.read(bytes, size) : tcp_.read(bytes, size); }
  int write(const uint8_t* bytes, size_t size) { return is_tty_ ? tty_.write(bytes, size) : tcp_.write(bytes, size); }
  void wait(uint32_t wait_ms) { is_tty_ ? tty_.wait(wait_ms) : tcp_.wait(wait_ms); }
  void close() {
    tty_.close();
    tcp_.close();
  }
  const char* name() const { return is_tty_ ? tty_.name() : tcp_.name(); }
  const char* reason() const { return is_tty_ ? tty_.reason() : tcp_.reason(); }
  bool isNetwork() const { return !is_tty_; }
  static uint32_t milliseconds() { return posixMilliseconds(); }

 private:
  bool is_tty_;
  TtyPipe tty_;
  TcpPipe<PosixSockets> tcp_;
};

}  // namespace ros

class EmbeddedLinuxHardware : public ros::PipeHardware<ros::PosixPipe> {
 public:
  explicit EmbeddedLinuxHardware(const char* port, long baud = 57600) : PipeHardware(ros::PosixPipe()) {
    pipe().setPort(port);
    setBaud(baud);
  }
  EmbeddedLinuxHardware() : PipeHardware(ros::PosixPipe()) {
    const char* port = getenv("ROSSERIAL_PORT");
    pipe().setPort(port ? port : DEFAULT_PORT);
  }

  // Takes effect with the next initNode.
  void setBaud(long baud) { pipe().tty().setBaud(baud); }
  long getBaud() { return pipe().tty().baud(); }

  using PipeHardware::init;
  void init(const char* port) {
    pipe().setPort(port);
    init();
  }
};

#endif
