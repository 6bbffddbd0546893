#ifndef ETHERNET_UDP_ON_HOST_H_
#define ETHERNET_UDP_ON_HOST_H_

#include <Ethernet.h>

class EthernetUDP : public Stream {
 public:
  EthernetUDP() : socket_(-1), out_size_(0), in_size_(0), in_next_(0) {}
  ~EthernetUDP() { stop(); }

  // Port 0 chooses a free one, so that tests can run at the same time.
  uint8_t begin(uint16_t port) { return open(IPAddress(127, 0, 0, 1), port); }
  // Receives datagrams to the group and, as a W5100 does, to its own address.
  uint8_t beginMulticast(IPAddress group, uint16_t port) {
    struct ip_mreq membership;
    membership.imr_multiaddr = socketAddress(group, port).sin_addr;
    membership.imr_interface = socketAddress(IPAddress(127, 0, 0, 1), port).sin_addr;
    return open(IPAddress(0, 0, 0, 0), port) &&
           setsockopt(socket_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) == 0;
  }
  void stop() {
    if (socket_ >= 0) close(socket_);
    socket_ = -1;
  }

  int beginPacket(IPAddress ip, uint16_t port) {
    to_ = socketAddress(ip, port);
    out_size_ = 0;
    return 1;
  }
  size_t write(uint8_t byte) { return write(&byte, 1); }
  size_t write(const uint8_t* bytes, size_t size) {
    size_t count = 0;
    while (count < size && out_size_ < sizeof out_) out_[out_size_++] = bytes[count++];
    return count;
  }
  int endPacket() {
    const ssize_t count = sendto(socket_, out_, out_size_, 0, reinterpret_cast<const struct sockaddr*>(&to_), sizeof to_);
    return count == static_cast<ssize_t>(out_size_);
  }

  int parsePacket() {
    socklen_t length = sizeof from_;
    const ssize_t count =
        recvfrom(socket_, in_, sizeof in_, MSG_DONTWAIT, reinterpret_cast<struct sockaddr*>(&from_), &length);
    in_next_ = 0;
    in_size_ = count > 0 ? static_cast<size_t>(count) : 0;
    return static_cast<int>(in_size_);
  }
  int available() { return static_cast<int>(in_size_ - in_next_); }
  int read() { return in_next_ < in_size_ ? in_[in_next_++] : -1; }
  int read(unsigned char* bytes, size_t size) {
    size_t count = 0;
    while (count < size && in_next_ < in_size_) bytes[count++] = in_[in_next_++];
    return static_cast<int>(count);
  }
  IPAddress remoteIP() {
    const uint32_t ip = ntohl(from_.sin_addr.s_addr);
    return IPAddress(static_cast<uint8_t>(ip >> 24), static_cast<uint8_t>(ip >> 16), static_cast<uint8_t>(ip >> 8),
                     static_cast<uint8_t>(ip));
  }
  uint16_t remotePort() { return ntohs(from_.sin_port); }

 private:
  bool open(const IPAddress& ip, uint16_t port) {
    const int yes = 1;
    const struct sockaddr_in address = socketAddress(ip, port);
    socket_ = socket(AF_INET, SOCK_DGRAM, 0);
    // A second socket may answer from the same port.
    setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    return bind(socket_, reinterpret_cast<const struct sockaddr*>(&address), sizeof address) == 0;
  }

  int socket_;
  struct sockaddr_in to_;
  struct sockaddr_in from_;
  // The capacity of the smallest chip.
  uint8_t out_[2048];
  size_t out_size_;
  uint8_t in_[2048];
  size_t in_size_;
  size_t in_next_;
};

#endif
