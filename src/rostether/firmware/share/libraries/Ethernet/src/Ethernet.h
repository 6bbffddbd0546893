// A TCP client on the network chip of a simulated board, with the interface of Arduino's Ethernet library.
//
// The chip is two registers of the AVR that real boards leave to programs. GPIOR1 is data: while idle it takes the
// address (four bytes, then the port, low byte first); when connected, writing sends a byte and reading receives
// one. GPIOR0 is command and status: writing 1 connects, 2 stops; bit 0 reads connected, bit 1 a byte is waiting,
// bit 2 there is room to send. It carries one connection at a time.
#ifndef ethernet_h_
#define ethernet_h_

#include <Arduino.h>
#include <Client.h>
#include <IPAddress.h>

enum EthernetLinkStatus { Unknown, LinkON, LinkOFF };
enum EthernetHardwareStatus { EthernetNoHardware, EthernetW5100, EthernetW5200, EthernetW5500 };

class EthernetClass {
 public:
  // With an address, or without one as if DHCP had given 10.0.0.2: the simulated network needs none.
  int begin(uint8_t* mac, unsigned long timeout_ms = 60000, unsigned long response_timeout_ms = 4000);
  void begin(uint8_t* mac, IPAddress ip);
  void begin(uint8_t* mac, IPAddress ip, IPAddress dns);
  void begin(uint8_t* mac, IPAddress ip, IPAddress dns, IPAddress gateway);
  void begin(uint8_t* mac, IPAddress ip, IPAddress dns, IPAddress gateway, IPAddress subnet);
  static void init(uint8_t) {}
  int maintain() { return 0; }
  EthernetLinkStatus linkStatus() { return LinkON; }
  EthernetHardwareStatus hardwareStatus() { return EthernetW5500; }
  IPAddress localIP() { return ip_; }
  IPAddress subnetMask() { return IPAddress(255, 255, 255, 0); }
  IPAddress gatewayIP() { return IPAddress(10, 0, 0, 1); }
  IPAddress dnsServerIP() { return gatewayIP(); }

 private:
  IPAddress ip_;
};

extern EthernetClass Ethernet;

class EthernetClient : public Client {
 public:
  // 1 when connected, 0 when nobody answers within a second.
  virtual int connect(IPAddress ip, uint16_t port);
  // A name reaches what every address reaches: the host that the simulated board was started with.
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
