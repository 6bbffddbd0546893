// The platforms' node as a sketch.
#if defined(USE_ETHERNET_H)
#include <SPI.h>
#include <Ethernet.h>
#endif
#include "platform_node.h"

void setup() {
#if defined(ROSSERIAL_ARDUINO_TCP) || defined(ROSSERIAL_ARDUINO_UDP) || (defined(ESP8266) && !defined(ESP_SERIAL))
  IPAddress server(192, 168, 0, 11);
  const uint16_t port = 11411;
  nh.getHardware()->setConnection(server, port);
  nh.initNode();
  const IPAddress own = nh.getHardware()->getLocalIP();
  (void)own;
#else
  nh.getHardware()->setBaud(115200);
  nh.initNode();
#endif
  setupNode();
}

void loop() { loopNode(); }
