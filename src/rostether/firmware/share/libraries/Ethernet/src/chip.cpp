// The part of `Ethernet` that needs the W5100: separate, so that sketches without UDP do not contain its code.
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
  W5100.setIPAddress(ip_);
  W5100.setGatewayIp(gateway_);
  W5100.setSubnetMask(mask_);
}
