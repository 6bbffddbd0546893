// Windows: a serial port or TCP, chosen by its name. Link with ws2_32, and include <ros.h> before <windows.h>.
//
//   nh.initNode("COM3")                   COM and a number is a serial port
//   nh.initNode("127.0.0.1:11411")        anything else is a host, by default with the port 11411
//   nh.initNode()                         the name in the environment variable ROSSERIAL_PORT, or DEFAULT_PORT
#ifndef ROS_PLATFORM_WINDOWS_PORT_H_
#define ROS_PLATFORM_WINDOWS_PORT_H_

#include <stdlib.h>

#include "ros/platform/windows_tcp.h"

#include "ros/platform/windows_com.h"

#if !defined(DEFAULT_PORT)
#define DEFAULT_PORT "localhost"
#endif

namespace ros {

class WindowsPipe {
 public:
  WindowsPipe() : is_com_(false) {}

  ComPipe& com() { return com_; }
  void setPort(const char* port) {
    is_com_ = *port == '\\' || ((port[0] | 0x20) == 'c' && (port[1] | 0x20) == 'o' && (port[2] | 0x20) == 'm' &&
                                port[3] >= '0' && port[3] <= '9');
    if (is_com_) {
      com_.setName(port);
    } else {
      tcp_.setAddress(port);
    }
  }

  PipeState open(uint32_t wait_ms) { return is_com_ ? com_.open(wait_ms) : tcp_.open(wait_ms); }
  int read(uint8_t* bytes, size_t size) { return is_com_ ? com_.read(bytes, size) : tcp_.read(bytes, size); }
  int write(const uint8_t* bytes, size_t size) { return is_com_ ? com_.write(bytes, size) : tcp_.write(bytes, size); }
  void wait(uint32_t wait_ms) { is_com_ ? com_.wait(wait_ms) : tcp_.wait(wait_ms); }
  void close() {
    com_.close();
    tcp_.close();
  }
  const char* name() const { return is_com_ ? com_.name() : tcp_.name(); }
  const char* reason() const { return is_com_ ? com_.reason() : tcp_.reason(); }
  bool isNetwork() const { return !is_com_; }
  static uint32_t milliseconds() { return GetTickCount(); }

 private:
  bool is_com_;
  ComPipe com_;
  TcpPipe<WindowsSockets> tcp_;
};

}  // namespace ros

class WindowsHardware : public ros::PipeHardware<ros::WindowsPipe> {
 public:
  explicit WindowsHardware(const char* port, long baud = 57600) : PipeHardware(ros::WindowsPipe()) {
    pipe().setPort(port);
    setBaud(baud);
  }
  WindowsHardware() : PipeHardware(ros::WindowsPipe()) {
    const char* port = getenv("ROSSERIAL_PORT");
    pipe().setPort(port ? port : DEFAULT_PORT);
  }

  // Takes effect with the next initNode.
  void setBaud(long baud) { pipe().com().setBaud(baud); }
  long getBaud() { return pipe().com().baud(); }

  using PipeHardware::init;
  void init(const char* port) {
    pipe().setPort(port);
    init();
  }
};

#endif
