#include "EthernetUdp.h"

#include "Ethernet.h"
#include "utility/w5100.h"

namespace {

const uint8_t kNone = MAX_SOCK_NUM;
// The local port of each socket; 0 if the socket is free.
uint16_t ports[MAX_SOCK_NUM];

}  // namespace

EthernetUDP::EthernetUDP() : socket_(kNone), remote_port_(0), remaining_(0) {}

uint8_t EthernetUDP::begin(uint16_t port) { return open(port, SnMR::UDP); }

uint8_t EthernetUDP::beginMulticast(IPAddress group, uint16_t port) {
  remote_ip_ = group;
  return open(port, SnMR::UDP | SnMR::MULTI);
}

uint8_t EthernetUDP::open(uint16_t port, uint8_t mode) {
  stop();
  Ethernet.startChip();
  uint8_t free = 0;
  while (free < MAX_SOCK_NUM && ports[free]) ++free;
  if (free == MAX_SOCK_NUM) return 0;
  socket_ = free;
  ports[free] = port;
  if (mode & SnMR::MULTI) {
    uint8_t ip[4];
    for (uint8_t i = 0; i < sizeof ip; ++i) ip[i] = remote_ip_[i];
    const uint8_t mac[] = {0x01, 0x00, 0x5e, static_cast<uint8_t>(ip[1] & 0x7f), ip[2], ip[3]};
    W5100.writeSnDIPR(socket_, ip);
    W5100.writeSnDPORT(socket_, port);
    W5100.writeSnDHAR(socket_, mac);
  }
  W5100.writeSnMR(socket_, mode);
  W5100.writeSnPORT(socket_, port);
  W5100.execCmdSn(socket_, Sock_OPEN);
  return 1;
}

void EthernetUDP::stop() {
  if (socket_ == kNone) return;
  W5100.execCmdSn(socket_, Sock_CLOSE);
  ports[socket_] = 0;
  socket_ = kNone;
  remaining_ = 0;
}

int EthernetUDP::beginPacket(IPAddress ip, uint16_t port) {
  if (socket_ == kNone) return 0;
  uint8_t bytes[4];
  for (uint8_t i = 0; i < sizeof bytes; ++i) bytes[i] = ip[i];
  W5100.writeSnDIPR(socket_, bytes);
  W5100.writeSnDPORT(socket_, port);
  return 1;
}

int EthernetUDP::beginPacket(const char* host, uint16_t port) {
  IPAddress ip;
  return ip.fromString(host) ? beginPacket(ip, port) : 0;
}

size_t EthernetUDP::write(const uint8_t* bytes, size_t size) {
  if (socket_ == kNone) return 0;
  const uint16_t room = W5100.getTXFreeSize(socket_);
  if (size > room) size = room;
  W5100.send_data_processing(socket_, bytes, size);
  return size;
}

int EthernetUDP::endPacket() {
  if (socket_ == kNone) return 0;
  W5100.execCmdSn(socket_, Sock_SEND);
  uint8_t flags;
  while (!((flags = W5100.readSnIR(socket_)) & (SnIR::SEND_OK | SnIR::TIMEOUT))) {}
  W5100.writeSnIR(socket_, SnIR::SEND_OK | SnIR::TIMEOUT);
  return (flags & SnIR::SEND_OK) != 0;
}

void EthernetUDP::receive(uint8_t* bytes, uint16_t count) {
  W5100.recv_data_processing(socket_, bytes, count);
  W5100.execCmdSn(socket_, Sock_RECV);
}

int EthernetUDP::parsePacket() {
  // Skip the unread bytes of the previous packet.
  while (remaining_) read();
  if (socket_ == kNone || !W5100.getRXReceivedSize(socket_)) return 0;
  uint8_t header[8];
  receive(header, sizeof header);
  remote_ip_ = IPAddress(header);
  remote_port_ = static_cast<uint16_t>(header[4] << 8 | header[5]);
  remaining_ = static_cast<uint16_t>(header[6] << 8 | header[7]);
  return remaining_;
}

int EthernetUDP::read() {
  uint8_t byte;
  return read(&byte, 1) > 0 ? byte : -1;
}

int EthernetUDP::read(unsigned char* bytes, size_t size) {
  if (!remaining_) return -1;
  const uint16_t count = size < remaining_ ? size : remaining_;
  receive(bytes, count);
  remaining_ -= count;
  return count;
}

int EthernetUDP::peek() {
  if (!remaining_) return -1;
  uint8_t byte;
  W5100.recv_data_processing(socket_, &byte, 1, 1);
  return byte;
}
