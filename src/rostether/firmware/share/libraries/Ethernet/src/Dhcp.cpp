// Gets an address by DHCP (RFC 2131); the sketch keeps it for as long as it runs.
#include <string.h>

#include "Ethernet.h"

namespace {

const uint16_t kServerPort = 67, kClientPort = 68;
const uint8_t kDiscover = 1, kOffer = 2, kRequest = 3, kAccept = 5;
const uint8_t kMask = 1, kRouter = 3, kDns = 6, kAddress = 50, kKind = 53, kServer = 54, kEnd = 255;
const uint16_t kHeaderBytes = 236;
const uint8_t kMagic[] = {0x63, 0x82, 0x53, 0x63};
const uint8_t kTransaction[] = {'r', 'o', 's', 1};

struct Answer {
  uint8_t kind;
  uint8_t ip[4], mask[4], router[4], dns[4], server[4];
};

void pad(EthernetUDP& udp, uint16_t count) {
  while (count--) udp.write(static_cast<uint8_t>(0));
}

void send(EthernetUDP& udp, const uint8_t* mac, uint8_t kind, const Answer& offer) {
  udp.beginPacket(IPAddress(255, 255, 255, 255), kServerPort);
  // A request on Ethernet with a hardware address of 6 bytes; the flag 0x80 asks for the answer as a broadcast.
  const uint8_t begin[] = {1, 1, 6, 0, kTransaction[0], kTransaction[1], kTransaction[2], kTransaction[3], 0, 0, 0x80, 0};
  udp.write(begin, sizeof begin);
  pad(udp, 28 - sizeof begin);
  udp.write(mac, 6);
  pad(udp, kHeaderBytes - 34);
  udp.write(kMagic, sizeof kMagic);
  const uint8_t options[] = {kKind, 1, kind};
  udp.write(options, sizeof options);
  if (kind == kRequest) {
    const uint8_t address[] = {kAddress, 4}, server[] = {kServer, 4};
    udp.write(address, sizeof address);
    udp.write(offer.ip, 4);
    udp.write(server, sizeof server);
    udp.write(offer.server, 4);
  }
  udp.write(kEnd);
  udp.endPacket();
}

void skip(EthernetUDP& udp, uint16_t count) {
  while (count--) udp.read();
}

bool receive(EthernetUDP& udp, Answer& answer) {
  if (udp.parsePacket() <= static_cast<int>(kHeaderBytes + sizeof kMagic)) return false;
  uint8_t transaction[4];
  skip(udp, 4);
  udp.read(transaction, 4);
  skip(udp, 8);
  udp.read(answer.ip, 4);
  skip(udp, kHeaderBytes + sizeof kMagic - 20);
  if (memcmp(transaction, kTransaction, 4) != 0) return false;
  while (udp.available()) {
    const uint8_t option = udp.read();
    if (option == kEnd) break;
    if (!option) continue;
    const uint8_t length = udp.read();
    uint8_t value[4] = {0, 0, 0, 0};
    const uint8_t known = length < 4 ? length : 4;
    udp.read(value, known);
    skip(udp, length - known);
    if (option == kKind) answer.kind = value[0];
    if (option == kMask) memcpy(answer.mask, value, 4);
    if (option == kRouter) memcpy(answer.router, value, 4);
    if (option == kDns) memcpy(answer.dns, value, 4);
    if (option == kServer) memcpy(answer.server, value, 4);
  }
  return true;
}

bool ask(EthernetUDP& udp, const uint8_t* mac, uint8_t kind, uint8_t wanted, Answer& answer, unsigned long limit_ms) {
  send(udp, mac, kind, answer);
  const unsigned long start_ms = millis();
  do {
    if (receive(udp, answer) && answer.kind == wanted) return true;
  } while (millis() - start_ms < limit_ms);
  return false;
}

}  // namespace

int EthernetClass::begin(uint8_t* mac, unsigned long timeout_ms, unsigned long response_timeout_ms) {
  begin(mac, IPAddress(0, 0, 0, 0));
  EthernetUDP udp;
  if (!udp.begin(kClientPort)) return 0;
  const unsigned long start_ms = millis();
  Answer answer = Answer();
  bool done = false;
  do {
    done = ask(udp, mac, kDiscover, kOffer, answer, response_timeout_ms) &&
           ask(udp, mac, kRequest, kAccept, answer, response_timeout_ms);
  } while (!done && millis() - start_ms < timeout_ms);
  udp.stop();
  if (!done) return 0;
  begin(mac, IPAddress(answer.ip), IPAddress(answer.dns), IPAddress(answer.router), IPAddress(answer.mask));
  // Sketches may then use the chip directly.
  startChip();
  return 1;
}
