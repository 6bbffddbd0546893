// The network of a simulated board, with the interface of Arduino's Ethernet library.
//
// UDP and DHCP use a W5100 on SPI. TCP uses two registers of the AVR that have no function on real boards, for one
// connection at a time. GPIOR1 is data: while idle, write the address (four bytes, then the port, low byte first);
// while connected, writing sends a byte and reading receives one. GPIOR0 is command and status: writing 1 connects,
// 2 stops; bit 0 means connected, bit 1 that a byte is waiting, bit 2 that there is room to send.
#ifndef ethernet_h_
#define ethernet_h_

#include <Arduino.h>
#include <Client.h>
#include <IPAddress.h>

#include "EthernetUdp.h"

enum EthernetLinkStatus { Unknown, LinkON, LinkOFF };
enum EthernetHardwareStatus { EthernetNoHardware, EthernetW5100, EthernetW5200, EthernetW5500 };

class EthernetClass {
 public:
  // Gets an address by DHCP: returns 1, or 0 if no server offers one in time. The others set a fixed address.
  int begin(uint8_t* mac, unsigned long timeout_ms = 60000, unsigned long response_timeout_ms = 4000);
  void begin(uint8_t* mac, IPAddress ip);
  void begin(uint8_t* mac, IPAddress ip, IPAddress dns);
  void begin(uint8_t* mac, IPAddress ip, IPAddress dns, IPAddress gateway);
  void begin(uint8_t* mac, IPAddress ip, IPAddress dns, IPAddress gateway, IPAddress subnet);
  static void init(uint8_t select_pin);
  int maintain() { return 0; }
  EthernetLinkStatus linkStatus() { return LinkON; }
  EthernetHardwareStatus hardwareStatus() { return EthernetW5100; }
  IPAddress localIP() { return IPAddress(ip_); }
  IPAddress subnetMask() { return IPAddress(mask_); }
  IPAddress gatewayIP() { return IPAddress(gateway_); }
  IPAddress dnsServerIP() { return IPAddress(dns_); }
  // Set how long the chip waits for the hardware address of another machine, and how many times it asks again.
  void setRetransmissionTimeout(uint16_t timeout_ms);
  void setRetransmissionCount(uint8_t count);

  // Sets up the W5100 if it does not have the sketch's addresses yet. EthernetUDP calls this.
  void startChip();

 private:
  uint8_t mac_[6];
  bool is_chip_started_;
  // Not IPAddress: sketches without UDP do not need its constructors.
  uint8_t ip_[4], dns_[4], gateway_[4], mask_[4];
};

extern EthernetClass Ethernet;

class EthernetClient : public Client {
 public:
  // Returns 1 when connected, 0 if there is no answer within a second.
  virtual int connect(IPAddress ip, uint16_t port);
  // Every name and every address leads to the host that the simulated board was started with.
  virtual int connect(const char* host, uint16_t port);
  virtual size_t write(uint8_t byte) { return write(&byte, 1); }
  virtual size_t write(const uint8_t* bytes, size_t size);
  virtual int available();
  virtual int read();
  virtual int read(uint8_t* bytes, size_t size);
  virtual int peek();
  virtual void flush() {}
  virtual void stop();
  virtual uint8_t connected();
  virtual operator bool();
  void setConnectionTimeout(uint16_t) {}

  using Print::write;
};

#endif
