// The part of Arduino's interfaces that platform/arduino*.h uses, on Linux: ports in memory, clients and UDP on
// sockets.
#ifndef ARDUINO_ON_HOST_H_
#define ARDUINO_ON_HOST_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

inline unsigned long millis() {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<unsigned long>(now.tv_sec) * 1000 + static_cast<unsigned long>(now.tv_nsec) / 1000000;
}
inline void delay(unsigned long wait_ms) { usleep(static_cast<useconds_t>(wait_ms * 1000)); }

class Print {
 public:
  virtual ~Print() {}
  virtual size_t write(uint8_t byte) = 0;
  virtual size_t write(const uint8_t* bytes, size_t size) {
    size_t count = 0;
    while (count < size && write(bytes[count])) ++count;
    return count;
  }
  virtual int availableForWrite() { return 0; }
};

class Stream : public Print {
 public:
  virtual int available() = 0;
  virtual int read() = 0;
};

class IPAddress {
 public:
  IPAddress() : octets_() {}
  IPAddress(uint8_t a, uint8_t b, uint8_t c, uint8_t d) {
    octets_[0] = a;
    octets_[1] = b;
    octets_[2] = c;
    octets_[3] = d;
  }
  IPAddress(uint32_t ip) { memcpy(octets_, &ip, sizeof octets_); }
  operator uint32_t() const {
    uint32_t ip;
    memcpy(&ip, octets_, sizeof ip);
    return ip;
  }
  uint8_t operator[](int index) const { return octets_[index]; }
  bool operator==(const IPAddress& other) const {
    return octets_[0] == other[0] && octets_[1] == other[1] && octets_[2] == other[2] && octets_[3] == other[3];
  }

 private:
  uint8_t octets_[4];
};

// Serial of this board: the test sets the received bytes.
class HardwareSerial : public Stream {
 public:
  void begin(unsigned long baud) { baud_ = baud; }
  size_t write(uint8_t) { return 1; }
  using Print::write;
  int availableForWrite() { return 63; }
  int available() { return 0; }
  int read() { return -1; }

  unsigned long baud_;
};
extern HardwareSerial Serial;

#endif
