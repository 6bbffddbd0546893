// A TCP connection to the host, from Windows. Link with ws2_32.
#ifndef ROS_PLATFORM_WINDOWS_TCP_H_
#define ROS_PLATFORM_WINDOWS_TCP_H_

// winsock2.h must come first: otherwise, windows.h includes the older winsock.h, which conflicts with it.
#include <winsock2.h>
#include <ws2tcpip.h>
#include <windows.h>

#include "ros/platform/tcp_pipe.h"

#if defined(_MSC_VER)
#pragma comment(lib, "ws2_32.lib")
#endif

namespace ros {

struct WindowsSockets {
  typedef SOCKET Handle;
  static const SOCKET NONE = INVALID_SOCKET;

  static void start() {
    WSADATA data;
    WSAStartup(MAKEWORD(2, 2), &data);
  }
  static uint32_t milliseconds() { return GetTickCount(); }

  // Starts to connect. Returns the socket, or NONE if that failed.
  static SOCKET connect(const struct sockaddr* address, int length) {
    const SOCKET handle = socket(address->sa_family, SOCK_STREAM, IPPROTO_TCP);
    if (handle == INVALID_SOCKET) return NONE;
    u_long unblocking = 1;
    ioctlsocket(handle, FIONBIO, &unblocking);
    const BOOL on = TRUE;
    setsockopt(handle, IPPROTO_TCP, TCP_NODELAY, reinterpret_cast<const char*>(&on), sizeof on);
    setsockopt(handle, SOL_SOCKET, SO_KEEPALIVE, reinterpret_cast<const char*>(&on), sizeof on);
    if (::connect(handle, address, length) == 0 || isTemporary()) return handle;
    close(handle);
    return NONE;
  }

  static PipeState connected(SOCKET handle, uint32_t wait_ms) {
    Sets sets(handle);
    struct timeval limit = {0, static_cast<long>(wait_ms * 1000)};
    // A refused connection is reported only as an exception.
    if (select(0, nullptr, &sets.writable, &sets.failed, &limit) <= 0) return PIPE_PENDING;
    return FD_ISSET(handle, &sets.writable) ? PIPE_OPEN : PIPE_FAILED;
  }
  static const char* reason() { return "cannot connect"; }

  static int read(SOCKET handle, uint8_t* bytes, size_t size) {
    const int count = recv(handle, reinterpret_cast<char*>(bytes), static_cast<int>(size), 0);
    if (count > 0) return count;
    return count < 0 && isTemporary() ? 0 : -1;
  }

  static int write(SOCKET handle, const uint8_t* bytes, size_t size) {
    const int count = send(handle, reinterpret_cast<const char*>(bytes), static_cast<int>(size), 0);
    if (count >= 0) return count;
    return isTemporary() ? 0 : -1;
  }

  static void wait(SOCKET handle, uint32_t wait_ms) {
    Sets sets(handle);
    struct timeval limit = {0, static_cast<long>(wait_ms * 1000)};
    select(0, &sets.readable, &sets.writable, nullptr, &limit);
  }

  static void close(SOCKET handle) { closesocket(handle); }

 private:
  struct Sets {
    explicit Sets(SOCKET handle) {
      readable.fd_count = writable.fd_count = failed.fd_count = 1;
      readable.fd_array[0] = writable.fd_array[0] = failed.fd_array[0] = handle;
    }
    fd_set readable, writable, failed;
  };

  static bool isTemporary() { return WSAGetLastError() == WSAEWOULDBLOCK; }
};

}  // namespace ros

// For programs that only connect over TCP: ros::NodeHandle_<WindowsSocket>.
class WindowsSocket : public ros::PipeHardware<ros::TcpPipe<ros::WindowsSockets> > {
 public:
  explicit WindowsSocket(const char* address = "localhost") : PipeHardware(ros::TcpPipe<ros::WindowsSockets>()) {
    pipe().setAddress(address);
  }

  using PipeHardware::init;
  void init(const char* address) {
    pipe().setAddress(address);
    init();
  }
};

#endif
