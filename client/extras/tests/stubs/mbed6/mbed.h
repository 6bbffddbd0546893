// The part of Mbed OS 6 that the library uses. cortexm/mbed_kit.cpp implements it for a simulated board.
#ifndef STUB_MBED_H_
#define STUB_MBED_H_

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include <chrono>

#define MBED_MAJOR_VERSION 6

enum PinName { USBTX, USBRX, p13, p14 };

namespace mbed {

class BufferedSerial {
 public:
  BufferedSerial(PinName tx, PinName rx, int baud = 9600);
  void set_baud(int baud);
  bool readable() const;
  ssize_t read(void* buffer, size_t length);
  ssize_t write(const void* buffer, size_t length);
};

class Timer {
 public:
  void start();
  std::chrono::microseconds elapsed_time() const;

 private:
  uint32_t began_us_;
};

}  // namespace mbed

using namespace mbed;

#endif
