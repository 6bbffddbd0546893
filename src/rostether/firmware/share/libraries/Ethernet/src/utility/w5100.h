// A WIZnet W5100 on SPI: its registers, and the packet memory of its four sockets.
//
// The names are those of version 1 of Arduino's Ethernet library, because some sketches use the chip directly.
// Source: the W5100 datasheet, version 1.2.
#ifndef w5100_h_
#define w5100_h_

#include <Arduino.h>

class SnMR {
 public:
  static const uint8_t CLOSE = 0x00, TCP = 0x01, UDP = 0x02, MULTI = 0x80;
};

class SnIR {
 public:
  static const uint8_t RECV = 0x04, TIMEOUT = 0x08, SEND_OK = 0x10;
};

class SnSR {
 public:
  static const uint8_t CLOSED = 0x00, UDP = 0x22;
};

enum SockCMD { Sock_OPEN = 0x01, Sock_CLOSE = 0x10, Sock_SEND = 0x20, Sock_RECV = 0x40 };

typedef uint8_t SOCKET;
#define MAX_SOCK_NUM 4

class W5100Class {
 public:
  // The pin of the chip's select input; 10 on Arduino's shields.
  static void select(uint8_t pin);
  // Resets the chip; the first call starts SPI.
  static void init();

  static uint8_t read(uint16_t address);
  static void read(uint16_t address, uint8_t* bytes, uint16_t count);
  static uint16_t read16(uint16_t address);
  static void write(uint16_t address, uint8_t byte);
  static void write(uint16_t address, const uint8_t* bytes, uint16_t count);
  static void write16(uint16_t address, uint16_t value);

  static void setGatewayIp(const uint8_t* ip) { write(0x0001, ip, 4); }
  static void setSubnetMask(const uint8_t* mask) { write(0x0005, mask, 4); }
  static void setMACAddress(const uint8_t* mac) { write(0x0009, mac, 6); }
  static void setIPAddress(const uint8_t* ip) { write(0x000f, ip, 4); }
  // Sets the time between retransmissions, in units of 100 microseconds.
  static void setRetransmissionTime(uint16_t timeout) { write16(0x0017, timeout); }
  static void setRetransmissionCount(uint8_t count) { write(0x0019, count); }

  static void writeSnMR(SOCKET s, uint8_t mode) { write(at(s, 0x00), mode); }
  static void writeSnIR(SOCKET s, uint8_t flags) { write(at(s, 0x02), flags); }
  static uint8_t readSnIR(SOCKET s) { return read(at(s, 0x02)); }
  static uint8_t readSnSR(SOCKET s) { return read(at(s, 0x03)); }
  static void writeSnPORT(SOCKET s, uint16_t port) { write16(at(s, 0x04), port); }
  static void writeSnDHAR(SOCKET s, const uint8_t* mac) { write(at(s, 0x06), mac, 6); }
  static void writeSnDIPR(SOCKET s, const uint8_t* ip) { write(at(s, 0x0c), ip, 4); }
  static void writeSnDPORT(SOCKET s, uint16_t port) { write16(at(s, 0x10), port); }

  // Waits until the chip has accepted the command.
  static void execCmdSn(SOCKET s, SockCMD command);
  static uint16_t getRXReceivedSize(SOCKET s) { return read_counter(at(s, 0x26)); }
  static uint16_t getTXFreeSize(SOCKET s) { return read_counter(at(s, 0x20)); }
  // Reads received bytes; Sock_RECV then frees their memory.
  static void recv_data_processing(SOCKET s, uint8_t* bytes, uint16_t count, uint8_t peek = 0);
  // Adds bytes to those that Sock_SEND will send.
  static void send_data_processing(SOCKET s, const uint8_t* bytes, uint16_t count);

 private:
  static uint16_t at(SOCKET s, uint16_t place) { return static_cast<uint16_t>(0x0400 + s * 0x100 + place); }
  static uint16_t read_counter(uint16_t address);
  static uint8_t exchange(uint8_t operation, uint16_t address, uint8_t byte);
};

extern W5100Class W5100;

#endif
