// The platforms' node as a sketch with ROSSERIAL_ARDUINO_TCP or ROSSERIAL_ARDUINO_UDP. The host is on the same
// computer; its port is the first argument.
#include <SPI.h>
#include <Ethernet.h>

#include "../platforms/platform_node.h"

#include <stdlib.h>

HardwareSerial Serial;
EthernetClass Ethernet;

int main(int, char** argv) {
  IPAddress server(127, 0, 0, 1);
  const uint16_t port = static_cast<uint16_t>(atoi(argv[1]));
#if defined(ROSSERIAL_ARDUINO_UDP)
  nh.getHardware()->setConnection(server, port, 0);
#else
  nh.getHardware()->setConnection(server, port);
#endif
  nh.initNode();
  setupNode();
  for (;;) {
    loopNode();
    delay(5);
  }
}
