#ifndef STUB_WIFI_H_
#define STUB_WIFI_H_

#include <Arduino.h>

enum { WL_CONNECTED = 3 };

class WiFiClass {
 public:
  int begin(const char* ssid, const char* passphrase);
  uint8_t status();
  int32_t RSSI();
#if defined(ESP32)
  bool setSleep(bool);
#endif
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
#if defined(ESP8266)
  uint8_t beginMulticast(IPAddress interface, IPAddress group, uint16_t port);
#endif
  STUB_UDP
};

#endif
