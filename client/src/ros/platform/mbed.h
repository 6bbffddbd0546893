// Mbed boards, over a UART: USBTX and USBRX (the debugger's port), or MBEDTX and MBEDRX if the build defines them.
//
// A class of the program can use other pins:
//   class Port : public MbedHardware {
//    public:
//     Port() : MbedHardware(p13, p14, 115200) {}
//   };
//   ros::NodeHandle_<Port> nh;
#ifndef ROS_PLATFORM_MBED_H_
#define ROS_PLATFORM_MBED_H_

#include <mbed.h>

#include "ros/platform/byte_ring.h"

#if !defined(MBEDTX) || !defined(MBEDRX)
#define ROS_MBED_TX USBTX
#define ROS_MBED_RX USBRX
#else
#define ROS_MBED_TX MBEDTX
#define ROS_MBED_RX MBEDRX
#endif

#if defined(MBED_MAJOR_VERSION) && MBED_MAJOR_VERSION >= 6

class MbedHardware {
 public:
  MbedHardware() : port_(ROS_MBED_TX, ROS_MBED_RX, 57600), baud_(57600) { timer_.start(); }
  MbedHardware(PinName tx, PinName rx, long baud = 57600) : port_(tx, rx, static_cast<int>(baud)), baud_(baud) {
    timer_.start();
  }

  // Takes effect with the next initNode.
  void setBaud(long baud) { baud_ = baud; }
  long getBaud() const { return baud_; }

  void init() { port_.set_baud(static_cast<int>(baud_)); }
  int read() {
    uint8_t byte;
    return port_.readable() && port_.read(&byte, 1) == 1 ? byte : -1;
  }
  void write(uint8_t* bytes, int count) { port_.write(bytes, static_cast<size_t>(count)); }
  unsigned long time() { return static_cast<unsigned long>(timer_.elapsed_time().count() / 1000); }

 private:
  mbed::BufferedSerial port_;
  mbed::Timer timer_;
  long baud_;
};

#else

// Mbed 2 and 5 have no port with a buffer: an interrupt stores received bytes.
class MbedHardware {
 public:
  MbedHardware() : port_(ROS_MBED_TX, ROS_MBED_RX), received_(), baud_(57600), seen_us_(0), rest_us_(0), time_ms_(0) {
    timer_.start();
  }
  MbedHardware(PinName tx, PinName rx, long baud = 57600)
      : port_(tx, rx), received_(), baud_(baud), seen_us_(0), rest_us_(0), time_ms_(0) {
    timer_.start();
  }

  // Takes effect with the next initNode.
  void setBaud(long baud) { baud_ = baud; }
  long getBaud() const { return baud_; }

  void init() {
    port_.baud(static_cast<int>(baud_));
    port_.attach(callback(this, &MbedHardware::receive), RawSerial::RxIrq);
  }
  int read() { return received_.take(); }
  void write(uint8_t* bytes, int count) {
    for (int i = 0; i < count; ++i) port_.putc(bytes[i]);
  }
  // The timer counts microseconds and overflows after 71 minutes; its overflows are counted.
  unsigned long time() {
    const uint32_t now_us = static_cast<uint32_t>(timer_.read_us());
    rest_us_ += now_us - seen_us_;
    seen_us_ = now_us;
    time_ms_ += rest_us_ / 1000;
    rest_us_ %= 1000;
    return time_ms_;
  }

 private:
  void receive() {
    while (port_.readable()) received_.put(static_cast<uint8_t>(port_.getc()));
  }

  RawSerial port_;
  Timer timer_;
  ros::ByteRing<256> received_;
  long baud_;
  uint32_t seen_us_;
  uint32_t rest_us_;
  uint32_t time_ms_;
};

#endif

#endif
