// Arduino boards on a network, over UDP: one frame per datagram, without a connection.
//
//   #define ROSSERIAL_ARDUINO_UDP
//   #include <Ethernet.h>
//   #include <ros.h>
//   ...
//   nh.getHardware()->setConnection(server, 11411);
//   nh.initNode();
//
// The class is EthernetUDP; on boards with built-in Wi-Fi, or with ROSSERIAL_ARDUINO_WIFI, it is WiFiUDP.
// For any other class with Arduino's UDP interface, use ros::NodeHandle_<ArduinoUdpHardware<ThatClass> >.
#ifndef ROS_PLATFORM_ARDUINO_UDP_H_
#define ROS_PLATFORM_ARDUINO_UDP_H_

#include <Arduino.h>

#include "ros/frame_writer.h"
#include "ros/platform/arduino_network.h"

template <class NetworkUdp>
class ArduinoUdpHardware {
 public:
  ArduinoUdpHardware() : port_(11411), local_port_(11411), unsent_(0), packed_(0), unread_(0) {}

  void setConnection(const IPAddress& server, int port = 11411, int local_port = 11411) {
    server_ = server;
    port_ = static_cast<uint16_t>(port);
    local_port_ = static_cast<uint16_t>(local_port);
  }
  NetworkUdp& udp() { return udp_; }

  void init() {
    udp_.stop();
    udp_.begin(local_port_);
    unsent_ = packed_ = 0;
    unread_ = 0;
  }

  int read() {
    while (unread_ <= 0) {
      unread_ = udp_.parsePacket();
      if (unread_ <= 0) return -1;
      // Any program may send to this port; packets that are not from the host are dropped.
      if (!(udp_.remoteIP() == server_) || udp_.remotePort() != port_) unread_ = 0;
    }
    const int byte = udp_.read();
    unread_ = byte < 0 ? 0 : unread_ - 1;
    return byte;
  }

  // The node writes whole frames in one or several chunks. The first chunk contains the frame's length.
  void write(uint8_t* bytes, int count) {
    if (!unsent_) unsent_ = static_cast<uint16_t>((bytes[2] | bytes[3] << 8) + ros::FRAME_OVERHEAD_BYTES);
    unsent_ = static_cast<uint16_t>(unsent_ - count);
    if (!packed_) udp_.beginPacket(server_, port_);
    udp_.write(static_cast<const uint8_t*>(bytes), static_cast<size_t>(count));
    packed_ = static_cast<uint16_t>(packed_ + count);
    if (unsent_ && packed_ + ros::FrameWriter::CHUNK_BYTES <= LONGEST_DATAGRAM_BYTES) return;
    udp_.endPacket();
    packed_ = 0;
  }

  unsigned long time() { return millis(); }

 private:
  // This fits in every network chip, and networks do not split it. The host treats datagrams as pieces of one stream of
  // bytes, so a longer frame can be sent in several datagrams.
  static const uint16_t LONGEST_DATAGRAM_BYTES = 1400;

  NetworkUdp udp_;
  IPAddress server_;
  uint16_t port_;
  uint16_t local_port_;
  uint16_t unsent_;  // bytes of the frame that the node has not written yet
  uint16_t packed_;  // bytes in the datagram in progress
  int unread_;       // unread bytes of the received datagram
};

class ArduinoHardware : public ArduinoUdpHardware<ros::BoardUdp> {
 public:
  IPAddress getLocalIP() { return ros::boardAddress(); }
};

#endif
