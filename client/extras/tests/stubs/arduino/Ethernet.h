#ifndef STUB_ETHERNET_H_
#define STUB_ETHERNET_H_

#include <Arduino.h>

class EthernetClass {
 public:
  static IPAddress localIP();
};
extern EthernetClass Ethernet;

class EthernetClient : public Client {
 public:
  STUB_CLIENT
};

class EthernetUDP : public UDP {
 public:
  STUB_UDP
};

#endif
