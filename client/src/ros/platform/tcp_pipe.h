#ifndef ROS_PLATFORM_TCP_PIPE_H_
#define ROS_PLATFORM_TCP_PIPE_H_

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ros/platform/pipe_hardware.h"

namespace ros {

// A TCP connection to "host", "host:port" or "[address]:port" as a Pipe for PipeHardware. Sockets has the system's
// functions.
//
// A name is looked up only once if possible: a look-up blocks, and spinOnce should not block.
template <class Sockets>
class TcpPipe {
 public:
  TcpPipe() : count_(0), current_(0), socket_(Sockets::NONE), began_ms_(0), reason_("") { setAddress(""); }
  TcpPipe(const TcpPipe& other) : count_(0), current_(0), socket_(Sockets::NONE), began_ms_(0), reason_("") {
    setAddress(other.address_);
  }
  TcpPipe& operator=(const TcpPipe&) = delete;

  void setAddress(const char* address) {
    if (address != address_) snprintf(address_, sizeof address_, "%s", address);
    count_ = 0;
  }
  const char* name() const { return address_; }
  const char* reason() const { return reason_; }

  PipeState open(uint32_t wait_ms) {
    if (!count_ && !lookUp()) return PIPE_FAILED;
    if (socket_ == Sockets::NONE) {
      current_ = 0;
      begin();
    }
    // If one address of a name refuses the connection, tries the next one.
    for (;;) {
      if (socket_ != Sockets::NONE) {
        const PipeState state = Sockets::connected(socket_, wait_ms);
        if (state == PIPE_OPEN) return PIPE_OPEN;
        if (state == PIPE_PENDING && milliseconds() - began_ms_ < CONNECT_MS) return PIPE_PENDING;
        close();
      }
      reason_ = Sockets::reason();
      if (++current_ >= count_) return PIPE_FAILED;
      begin();
    }
  }

  int read(uint8_t* bytes, size_t size) { return Sockets::read(socket_, bytes, size); }
  int write(const uint8_t* bytes, size_t size) { return Sockets::write(socket_, bytes, size); }
  void wait(uint32_t wait_ms) { Sockets::wait(socket_, wait_ms); }
  void close() {
    if (socket_ != Sockets::NONE) Sockets::close(socket_);
    socket_ = Sockets::NONE;
  }
  static bool isNetwork() { return true; }
  static uint32_t milliseconds() { return Sockets::milliseconds(); }

 private:
  static const int MAX_ADDRESSES = 4;
  // Long enough for the first two retransmissions of a lost SYN, after 1 and 3 s.
  static const uint32_t CONNECT_MS = 4000;

  bool lookUp() {
    char host[sizeof address_];
    const char* port = "11411";
    const char* name = address_;
    const char* end = name + strlen(name);
    if (*name == '[' && strchr(name, ']')) {
      end = strchr(++name, ']');
      if (end[1] == ':') port = end + 2;
    } else if (strchr(name, ':') && strchr(name, ':') == strrchr(name, ':')) {
      end = strchr(name, ':');
      port = end + 1;
    }
    snprintf(host, sizeof host, "%.*s", static_cast<int>(end - name), name);
    // As in the established library, a port that is not a number means the default port.
    if (atoi(port) <= 0) port = "11411";
    Sockets::start();
    struct addrinfo hints;
    memset(&hints, 0, sizeof hints);
    hints.ai_socktype = SOCK_STREAM;
    struct addrinfo* found = nullptr;
    if (getaddrinfo(host, port, &hints, &found) != 0) {
      reason_ = "no such host";
      return false;
    }
    for (struct addrinfo* one = found; one && count_ < MAX_ADDRESSES; one = one->ai_next) {
      if (one->ai_addrlen > sizeof addresses_[0]) continue;
      memcpy(&addresses_[count_], one->ai_addr, one->ai_addrlen);
      lengths_[count_++] = static_cast<int>(one->ai_addrlen);
    }
    freeaddrinfo(found);
    return count_ > 0;
  }

  void begin() {
    began_ms_ = milliseconds();
    socket_ = Sockets::connect(reinterpret_cast<struct sockaddr*>(&addresses_[current_]), lengths_[current_]);
  }

  char address_[300];
  struct sockaddr_storage addresses_[MAX_ADDRESSES];
  int lengths_[MAX_ADDRESSES];
  int count_;
  int current_;
  typename Sockets::Handle socket_;
  uint32_t began_ms_;
  const char* reason_;
};

}  // namespace ros

#endif
