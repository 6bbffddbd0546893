#include "Ethernet.h"

namespace {

const uint8_t kConnect = 1;
const uint8_t kStop = 2;
const uint8_t kIsConnected = 1;
const uint8_t kHasByte = 2;
const uint8_t kHasRoom = 4;
// As long as Arduino's library waits; the sketch is blocked during this time.
const unsigned long kTimeoutMs = 1000;

// The byte that `peek` has read, -1 for none: the chip cannot put it back.
int peeked = -1;

bool wait_for(uint8_t flag) {
  const unsigned long start = millis();
  while (!(GPIOR0 & flag)) {
    if (millis() - start >= kTimeoutMs) return false;
    if (flag != kIsConnected && !(GPIOR0 & kIsConnected)) return false;
  }
  return true;
}

void copy(IPAddress& from, uint8_t* to) {
  for (uint8_t i = 0; i < 4; ++i) to[i] = from[i];
}

}  // namespace

EthernetClass Ethernet;

void EthernetClass::begin(uint8_t* mac, IPAddress ip) {
  memcpy(mac_, mac, sizeof mac_);
  for (uint8_t i = 0; i < 4; ++i) {
    ip_[i] = dns_[i] = gateway_[i] = ip[i];
    mask_[i] = 255;
  }
  dns_[3] = gateway_[3] = 1;
  mask_[3] = 0;
  is_chip_started_ = false;
}
void EthernetClass::begin(uint8_t* mac, IPAddress ip, IPAddress dns) {
  begin(mac, ip);
  copy(dns, dns_);
}
void EthernetClass::begin(uint8_t* mac, IPAddress ip, IPAddress dns, IPAddress gateway) {
  begin(mac, ip, dns);
  copy(gateway, gateway_);
}
void EthernetClass::begin(uint8_t* mac, IPAddress ip, IPAddress dns, IPAddress gateway, IPAddress subnet) {
  begin(mac, ip, dns, gateway);
  copy(subnet, mask_);
}

int EthernetClient::connect(IPAddress ip, uint16_t port) {
  stop();
  for (uint8_t i = 0; i < 4; ++i) GPIOR1 = ip[i];
  GPIOR1 = static_cast<uint8_t>(port);
  GPIOR1 = static_cast<uint8_t>(port >> 8);
  GPIOR0 = kConnect;
  return wait_for(kIsConnected);
}

int EthernetClient::connect(const char* host, uint16_t port) {
  IPAddress ip;
  ip.fromString(host);
  return connect(ip, port);
}

size_t EthernetClient::write(const uint8_t* bytes, size_t size) {
  size_t sent = 0;
  while (sent < size && wait_for(kHasRoom)) GPIOR1 = bytes[sent++];
  if (sent < size) setWriteError();
  return sent;
}

int EthernetClient::available() { return (peeked >= 0) + ((GPIOR0 & kHasByte) != 0); }

int EthernetClient::read() {
  const int byte = peek();
  peeked = -1;
  return byte;
}

int EthernetClient::read(uint8_t* bytes, size_t size) {
  size_t taken = 0;
  while (taken < size && available()) bytes[taken++] = read();
  return taken ? static_cast<int>(taken) : -1;
}

int EthernetClient::peek() {
  if (peeked < 0 && (GPIOR0 & kHasByte)) peeked = GPIOR1;
  return peeked;
}

void EthernetClient::stop() {
  GPIOR0 = kStop;
  peeked = -1;
}

uint8_t EthernetClient::connected() { return (GPIOR0 & kIsConnected) || available(); }

EthernetClient::operator bool() { return connected(); }
