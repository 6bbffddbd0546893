// The network of an Arduino board: built-in Wi-Fi, or an Ethernet shield.
#ifndef ROS_PLATFORM_ARDUINO_NETWORK_H_
#define ROS_PLATFORM_ARDUINO_NETWORK_H_

#include <Arduino.h>

#if defined(ESP32_ETH)
#include <ETH.h>
#include <WiFi.h>
#define ROS_NETWORK ETH
#elif defined(ESP8266)
#include <ESP8266WiFi.h>
#define ROS_NETWORK WiFi
#elif defined(ARDUINO_UNOWIFIR4)
#include <WiFiS3.h>
#define ROS_NETWORK WiFi
#elif defined(ESP32) || defined(ARDUINO_RASPBERRY_PI_PICO_W) || defined(ROSSERIAL_ARDUINO_WIFI)
// For a board with another Wi-Fi library (WiFiNINA, WiFi101), the sketch must include that library before <ros.h>.
#if !defined(WiFi_h) && !defined(WIFI_H)
#include <WiFi.h>
#endif
#define ROS_NETWORK WiFi
#else
#define ROS_HAS_ETHERNET
#include <SPI.h>
#include <Ethernet.h>
#define ROS_NETWORK Ethernet
#endif

#if defined(ROSSERIAL_ARDUINO_UDP) && defined(ROS_HAS_ETHERNET)
#include <EthernetUdp.h>
#elif defined(ROSSERIAL_ARDUINO_UDP)
#include <WiFiUdp.h>
#endif

namespace ros {

#if defined(ROS_HAS_ETHERNET)
typedef EthernetClient BoardClient;
#else
typedef WiFiClient BoardClient;
#endif

#if defined(ROSSERIAL_ARDUINO_UDP) && defined(ROS_HAS_ETHERNET)
typedef EthernetUDP BoardUdp;
#elif defined(ROSSERIAL_ARDUINO_UDP)
typedef WiFiUDP BoardUdp;
#endif

inline IPAddress boardAddress() { return ROS_NETWORK.localIP(); }

}  // namespace ros

#endif
