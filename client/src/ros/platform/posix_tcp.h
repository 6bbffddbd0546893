// A TCP connection to the host, from Linux, macOS or another Unix.
#ifndef ROS_PLATFORM_POSIX_TCP_H_
#define ROS_PLATFORM_POSIX_TCP_H_

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>

#include "ros/platform/posix_clock.h"
#include "ros/platform/tcp_pipe.h"

namespace ros {

struct PosixSockets {
  typedef int Handle;
  static const int NONE = -1;

  static void start() {}
  static uint32_t milliseconds() { return posixMilliseconds(); }

  // Starts to connect. Returns the socket, or NONE if that failed.
  static int connect(const struct sockaddr* address, int length) {
    const int handle = socket(address->sa_family, SOCK_STREAM, 0);
    if (handle < 0) return NONE;
    const int on = 1;
    fcntl(handle, F_SETFL, fcntl(handle, F_GETFL, 0) | O_NONBLOCK);
    fcntl(handle, F_SETFD, FD_CLOEXEC);
    setsockopt(handle, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    setsockopt(handle, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
#if defined(SO_NOSIGPIPE)
    setsockopt(handle, SOL_SOCKET, SO_NOSIGPIPE, &on, sizeof on);
#endif
    if (::connect(handle, address, static_cast<socklen_t>(length)) == 0 || errno == EINPROGRESS) return handle;
    close(handle);
    return NONE;
  }

  static PipeState connected(int handle, uint32_t wait_ms) {
    struct pollfd waited = {handle, POLLOUT, 0};
    errno = ETIMEDOUT;
    if (poll(&waited, 1, static_cast<int>(wait_ms)) <= 0) return PIPE_PENDING;
    int error = 0;
    socklen_t size = sizeof error;
    if (getsockopt(handle, SOL_SOCKET, SO_ERROR, &error, &size) != 0) return PIPE_FAILED;
    errno = error;
    return error == 0 ? PIPE_OPEN : PIPE_FAILED;
  }
  // Returns why the last socket did not connect.
  static const char* reason() { return strerror(errno); }

  static int read(int handle, uint8_t* bytes, size_t size) {
    const ssize_t count = recv(handle, bytes, size, 0);
    if (count > 0) return static_cast<int>(count);
    return count < 0 && isTemporary() ? 0 : -1;
  }

  static int write(int handle, const uint8_t* bytes, size_t size) {
#if defined(MSG_NOSIGNAL)
    const ssize_t count = send(handle, bytes, size, MSG_NOSIGNAL);
#else
    const ssize_t count = send(handle, bytes, size, 0);
#endif
    if (count >= 0) return static_cast<int>(count);
    return isTemporary() ? 0 : -1;
  }

  static void wait(int handle, uint32_t wait_ms) {
    struct pollfd waited = {handle, POLLIN | POLLOUT, 0};
    poll(&waited, 1, static_cast<int>(wait_ms));
  }

  static void close(int handle) { ::close(handle); }

 private:
  static bool isTemporary() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }
};

}  // namespace ros

// For programs that only connect over TCP: ros::NodeHandle_<PosixTcp>.
class PosixTcp : public ros::PipeHardware<ros::TcpPipe<ros::PosixSockets> > {
 public:
  explicit PosixTcp(const char* address = "localhost") : PipeHardware(ros::TcpPipe<ros::PosixSockets>()) {
    pipe().setAddress(address);
  }

  using PipeHardware::init;
  void init(const char* address) {
    pipe().setAddress(address);
    init();
  }
};

#endif
