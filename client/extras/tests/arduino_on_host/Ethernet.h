#ifndef ETHERNET_ON_HOST_H_
#define ETHERNET_ON_HOST_H_

#include <Arduino.h>

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

inline struct sockaddr_in socketAddress(const IPAddress& ip, uint16_t port) {
  struct sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr =
      htonl(static_cast<uint32_t>(ip[0]) << 24 | static_cast<uint32_t>(ip[1]) << 16 | static_cast<uint32_t>(ip[2]) << 8 | ip[3]);
  return address;
}

class EthernetClass {
 public:
  IPAddress localIP() { return IPAddress(127, 0, 0, 1); }
};
extern EthernetClass Ethernet;

// Like the chips, it sends each write as a packet.
class EthernetClient : public Stream {
 public:
  EthernetClient() : socket_(-1) {}
  ~EthernetClient() { stop(); }

  int connect(IPAddress ip, uint16_t port) {
    stop();
    const int one = 1;
    const struct sockaddr_in address = socketAddress(ip, port);
    socket_ = socket(AF_INET, SOCK_STREAM, 0);
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    if (::connect(socket_, reinterpret_cast<const struct sockaddr*>(&address), sizeof address) == 0) return 1;
    stop();
    return 0;
  }
  size_t write(uint8_t byte) { return write(&byte, 1); }
  size_t write(const uint8_t* bytes, size_t size) {
    const ssize_t count = send(socket_, bytes, size, MSG_NOSIGNAL);
    return count < 0 ? 0 : static_cast<size_t>(count);
  }
  int available() { return 0; }
  int read() {
    uint8_t byte;
    return recv(socket_, &byte, 1, MSG_DONTWAIT) == 1 ? byte : -1;
  }
  void stop() {
    if (socket_ >= 0) close(socket_);
    socket_ = -1;
  }
  uint8_t connected() {
    uint8_t byte;
    const ssize_t count = recv(socket_, &byte, 1, MSG_DONTWAIT | MSG_PEEK);
    return count > 0 || (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK));
  }

 private:
  int socket_;
};

#endif
