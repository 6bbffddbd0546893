#ifndef ROS_PLATFORM_POSIX_BAUD_H_
#define ROS_PLATFORM_POSIX_BAUD_H_

#include <stdint.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>

namespace ros {

#if defined(__linux__)

// Returns the constant for a baud rate; B0 if there is none.
inline speed_t standardSpeed(long baud) {
  static const struct {
    long baud;
    speed_t speed;
  } table[] = {
      {1200, B1200},       {2400, B2400},       {4800, B4800},       {9600, B9600},       {19200, B19200},
      {38400, B38400},     {57600, B57600},     {115200, B115200},   {230400, B230400},   {460800, B460800},
      {500000, B500000},   {576000, B576000},   {921600, B921600},   {1000000, B1000000}, {1152000, B1152000},
      {1500000, B1500000}, {2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000}, {3500000, B3500000},
      {4000000, B4000000},
  };
  for (size_t i = 0; i < sizeof table / sizeof table[0]; ++i) {
    if (table[i].baud == baud) return table[i].speed;
  }
  return B0;
}

// Sets a baud rate without a constant (250000 is usual on an AVR at 16 MHz). Returns false if it cannot be set, and on
// processors whose kernel has another structure for it.
inline bool setUncommonBaud(int fd, long baud) {
#if defined(__x86_64__) || defined(__i386__) || defined(__arm__) || defined(__aarch64__) || defined(__riscv)
  // struct termios2 of asm/termbits.h, which cannot be included beside termios.h.
  struct {
    uint32_t iflag, oflag, cflag, lflag;
    uint8_t line, cc[19];
    uint32_t ispeed, ospeed;
  } line;
  const unsigned long get = _IOC(_IOC_READ, 'T', 0x2a, sizeof line);
  const unsigned long set = _IOC(_IOC_WRITE, 'T', 0x2b, sizeof line);
  const uint32_t any_rate = 0010000;
  const uint32_t rates = 0010017;
  if (baud <= 0 || ioctl(fd, get, &line) != 0) return false;
  line.cflag = (line.cflag & ~(rates | rates << 16)) | any_rate | any_rate << 16;
  line.ispeed = line.ospeed = static_cast<uint32_t>(baud);
  return ioctl(fd, set, &line) == 0;
#else
  return fd < 0 && baud < 0;
#endif
}

// Applies the settings `line` with this baud rate in both directions. Returns false if that fails.
inline bool setPosixBaud(int fd, struct termios& line, long baud) {
  const speed_t speed = standardSpeed(baud);
  cfsetispeed(&line, speed == B0 ? B38400 : speed);
  cfsetospeed(&line, speed == B0 ? B38400 : speed);
  if (tcsetattr(fd, TCSANOW, &line) != 0) return false;
  return speed != B0 || setUncommonBaud(fd, baud);
}

#else

// On other systems, the constant of a speed is its number.
inline bool setPosixBaud(int fd, struct termios& line, long baud) {
  return baud > 0 && cfsetispeed(&line, static_cast<speed_t>(baud)) == 0 &&
         cfsetospeed(&line, static_cast<speed_t>(baud)) == 0 && tcsetattr(fd, TCSANOW, &line) == 0;
}

#endif

}  // namespace ros

#endif
