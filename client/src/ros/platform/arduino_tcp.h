// Arduino boards on a network.
//
//   #define ROSSERIAL_ARDUINO_TCP
//   #include <Ethernet.h>
//   #include <ros.h>
//   ...
//   nh.getHardware()->setConnection(server, 11411);
//   nh.initNode();
//
// The client is EthernetClient; on boards with built-in Wi-Fi, or with ROSSERIAL_ARDUINO_WIFI, it is WiFiClient.
// For any other class with Arduino's Client interface, use ros::NodeHandle_<ArduinoTcpHardware<ThatClient> >.
#ifndef ROS_PLATFORM_ARDUINO_TCP_H_
#define ROS_PLATFORM_ARDUINO_TCP_H_

#include "ros/platform/arduino_tcp_hardware.h"

class ArduinoHardware : public ArduinoTcpHardware<ros::BoardClient> {
 public:
  IPAddress getLocalIP() { return ros::boardAddress(); }
};

#endif
