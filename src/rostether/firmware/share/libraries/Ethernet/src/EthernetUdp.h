// UDP on a W5100, with the interface of Arduino's Ethernet library.
#ifndef ethernet_udp_h_
#define ethernet_udp_h_

#include <Arduino.h>
#include <IPAddress.h>
#include <Udp.h>

#define UDP_TX_PACKET_MAX_SIZE 24

class EthernetUDP : public UDP {
 public:
  EthernetUDP();
  // Returns 1, or 0 if all four sockets of the chip are in use.
  virtual uint8_t begin(uint16_t port);
  virtual uint8_t beginMulticast(IPAddress group, uint16_t port);
  virtual void stop();

  virtual int beginPacket(IPAddress ip, uint16_t port);
  // Names are not resolved: returns 0 if `host` is not an address.
  virtual int beginPacket(const char* host, uint16_t port);
  // Waits until the packet is sent. Returns 1, or 0 if no machine has the address.
  virtual int endPacket();
  virtual size_t write(uint8_t byte) { return write(&byte, 1); }
  virtual size_t write(const uint8_t* bytes, size_t size);

  virtual int parsePacket();
  virtual int available() { return remaining_; }
  virtual int read();
  virtual int read(unsigned char* bytes, size_t size);
  virtual int read(char* bytes, size_t size) { return read(reinterpret_cast<unsigned char*>(bytes), size); }
  virtual int peek();
  virtual void flush() {}
  virtual IPAddress remoteIP() { return remote_ip_; }
  virtual uint16_t remotePort() { return remote_port_; }

  using Print::write;

 private:
  uint8_t open(uint16_t port, uint8_t mode);
  void receive(uint8_t* bytes, uint16_t count);

  uint8_t socket_;
  IPAddress remote_ip_;
  uint16_t remote_port_;
  uint16_t remaining_;
};

#endif
