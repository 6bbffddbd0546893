#ifndef STUB_WIFI_H_
#define STUB_WIFI_H_

#include <Arduino.h>

class WiFiClass {
 public:
  IPAddress localIP();
};
extern WiFiClass WiFi;

class WiFiClient : public Client {
 public:
#if defined(ESP32)
  int setNoDelay(bool);
#elif defined(ESP8266)
  void setNoDelay(bool);
#endif
  STUB_CLIENT
};

class WiFiUDP : public UDP {
 public:
  STUB_UDP
};

#endif
