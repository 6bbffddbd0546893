// A serial port of Linux, macOS or another Unix.
#ifndef ROS_PLATFORM_POSIX_TTY_H_
#define ROS_PLATFORM_POSIX_TTY_H_

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>

#include "ros/platform/pipe_hardware.h"
#include "ros/platform/posix_baud.h"
#include "ros/platform/posix_clock.h"

namespace ros {

// A terminal device as a Pipe for PipeHardware: raw, 8N1, without flow control.
class TtyPipe {
 public:
  TtyPipe() : baud_(57600), fd_(-1), reason_("") { path_[0] = '\0'; }
  TtyPipe(const TtyPipe& other) : baud_(other.baud_), fd_(-1), reason_("") { setPath(other.path_); }
  TtyPipe& operator=(const TtyPipe&) = delete;

  void setPath(const char* path) { snprintf(path_, sizeof path_, "%s", path); }
  void setBaud(long baud) { baud_ = baud; }
  long baud() const { return baud_; }
  const char* name() const { return path_; }
  const char* reason() const { return reason_; }

  PipeState open(uint32_t) {
    fd_ = ::open(path_, O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (fd_ < 0) {
      reason_ = strerror(errno);
      return PIPE_FAILED;
    }
    fcntl(fd_, F_SETFD, FD_CLOEXEC);
    struct termios line;
    if (tcgetattr(fd_, &line) != 0) {
      reason_ = "is not a serial port";
      close();
      return PIPE_FAILED;
    }
    line.c_iflag = 0;
    line.c_oflag = 0;
    line.c_lflag = 0;
    line.c_cflag &= ~static_cast<tcflag_t>(CSIZE | PARENB | CSTOPB);
#if defined(CRTSCTS)
    line.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS);
#endif
    line.c_cflag |= CS8 | CLOCAL | CREAD;
    // With these settings, an empty read means that the port has disappeared, not that it is quiet.
    line.c_cc[VMIN] = 1;
    line.c_cc[VTIME] = 0;
    if (!setPosixBaud(fd_, line, baud_)) {
      reason_ = "does not support this baud rate";
      close();
      return PIPE_FAILED;
    }
    return PIPE_OPEN;
  }

  int read(uint8_t* bytes, size_t size) {
    const ssize_t count = ::read(fd_, bytes, size);
    if (count > 0) return static_cast<int>(count);
    return count < 0 && isTemporary() ? 0 : -1;
  }
  int write(const uint8_t* bytes, size_t size) {
    const ssize_t count = ::write(fd_, bytes, size);
    if (count >= 0) return static_cast<int>(count);
    return isTemporary() ? 0 : -1;
  }
  void wait(uint32_t wait_ms) {
    struct pollfd waited = {fd_, POLLIN | POLLOUT, 0};
    poll(&waited, 1, static_cast<int>(wait_ms));
  }
  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }
  static bool isNetwork() { return false; }
  static uint32_t milliseconds() { return posixMilliseconds(); }

 private:
  static bool isTemporary() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

  char path_[300];
  long baud_;
  int fd_;
  const char* reason_;
};

}  // namespace ros

// For programs that only use a serial port: ros::NodeHandle_<PosixTty>.
class PosixTty : public ros::PipeHardware<ros::TtyPipe> {
 public:
  explicit PosixTty(const char* path = "/dev/ttyUSB0", long baud = 57600) : PipeHardware(ros::TtyPipe()) {
    pipe().setPath(path);
    pipe().setBaud(baud);
  }

  // Takes effect with the next initNode.
  void setBaud(long baud) { pipe().setBaud(baud); }
  long getBaud() { return pipe().baud(); }

  using PipeHardware::init;
  void init(const char* path) {
    pipe().setPath(path);
    init();
  }
};

#endif
