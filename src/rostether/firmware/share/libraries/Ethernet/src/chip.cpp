// What of `Ethernet` needs the W5100: apart, so that sketches without UDP do without its code.
#include "Ethernet.h"
#include "utility/w5100.h"

void EthernetClass::init(uint8_t select_pin) { W5100.select(select_pin); }

void EthernetClass::setRetransmissionTimeout(uint16_t timeout_ms) {
  startChip();
  W5100.setRetransmissionTime(static_cast<uint16_t>(timeout_ms * 10));
}

void EthernetClass::setRetransmissionCount(uint8_t count) {
  startChip();
  W5100.setRetransmissionCount(count);
}

void EthernetClass::startChip() {
  if (is_chip_started_) return;
  is_chip_started_ = true;
  W5100.init();
  W5100.setMACAddress(mac_);
  const IPAddress addresses[] = {ip_, gateway_, mask_};
  uint8_t bytes[3][4];
  for (uint8_t i = 0; i < 12; ++i) bytes[i / 4][i % 4] = addresses[i / 4][i % 4];
  W5100.setIPAddress(bytes[0]);
  W5100.setGatewayIp(bytes[1]);
  W5100.setSubnetMask(bytes[2]);
}
