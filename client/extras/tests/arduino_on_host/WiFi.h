#ifndef WIFI_ON_HOST_H_
#define WIFI_ON_HOST_H_

#include <Ethernet.h>

typedef EthernetClient WiFiClient;
#define WiFi Ethernet

#endif
