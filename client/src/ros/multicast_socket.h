// A UDP port in a multicast group, over any class with Arduino's UDP interface, that stays reachable.
#ifndef ROS_MULTICAST_SOCKET_H_
#define ROS_MULTICAST_SOCKET_H_

#include <Arduino.h>
#include <stddef.h>
#include <stdint.h>

#include "ros/inlining.h"

#if defined(ESP8266)
#include <ESP8266WiFi.h>
#endif

namespace ros {

// Whether answers need a separate socket: a socket of a W5100 or W5500 that has joined a group sends only to the group.
template <class NetworkUdp>
struct AnswersApart {
  enum { value = 0 };
};
#if defined(ethernet_h_)  // the sketch has included Arduino's Ethernet library
template <>
struct AnswersApart<EthernetUDP> {
  enum { value = 1 };
};
#endif
template <bool apart>
struct AnswersApartTag {};

// Network chips stop receiving from a group after some time, and switches forget the group's members. So a socket that
// receives nothing is opened again every second, and any other socket every minute. With a class that does not support
// multicast, it receives only unicast datagrams.
template <class NetworkUdp>
class MulticastSocket {
 public:
  void begin(uint32_t group, uint16_t port) {
    group_ = group;
    port_ = port;
    watch(static_cast<uint16_t>(millis()), true);
  }

  // Returns the size of the next datagram, which `udp` then reads; 0 or less if there is none.
  int next(uint16_t now_ms) {
    const int size = udp_.parsePacket();
    if (size > 0) received_ = ticks(now_ms);
    return size;
  }
  NetworkUdp& udp() { return udp_; }

  // Reads a datagram that is too long for the buffer. Otherwise, an ESP32 would receive no more datagrams; the chips
  // of AVR boards drop the rest.
  void skip(uint8_t* buffer, uint16_t buffer_bytes, size_t size) {
#if defined(__AVR__)
    (void)buffer, (void)buffer_bytes, (void)size;
#else
    for (size_t read = 0; read < size; read += buffer_bytes) udp_.read(buffer, buffer_bytes);
#endif
  }

  // Opens the socket again if that is due, or if `expected`: a datagram should have arrived.
  ROS_APART void watch(uint16_t now_ms, bool expected) {
    const uint8_t now = ticks(now_ms);
    const uint8_t open = static_cast<uint8_t>(now - opened_);
    if (!expected && open < REJOIN && (open < SILENCE || static_cast<uint8_t>(now - received_) < SILENCE)) return;
    opened_ = now;
    udp_.stop();
    if (!join(udp_, 0)) udp_.begin(port_);
  }

  void answer(const uint8_t* bytes, size_t size) {
    answerBy(AnswersApartTag<AnswersApart<NetworkUdp>::value>(), bytes, size);
  }

 private:
  // A second and a minute, in ticks of 256 ms: a byte is enough.
  static const uint8_t SILENCE = 4, REJOIN = 234;
  static uint8_t ticks(uint16_t ms) { return static_cast<uint8_t>(ms >> 8); }

  template <class Udp>
  auto join(Udp& udp, int) -> decltype(udp.beginMulticast(IPAddress(uint32_t()), uint16_t())) {
    return udp.beginMulticast(IPAddress(group_), port_);
  }
#if defined(ESP8266)
  template <class Udp>
  auto join(Udp& udp, int) -> decltype(udp.beginMulticast(IPAddress(uint32_t()), IPAddress(uint32_t()), uint16_t())) {
    return udp.beginMulticast(WiFi.localIP(), IPAddress(group_), port_);
  }
#endif
  template <class Udp>
  uint8_t join(Udp&, long) {
    return 0;
  }

  // Answers from the group's port, so that the sender can send unicast datagrams to the source of an answer.
  void answerBy(AnswersApartTag<true>, const uint8_t* bytes, size_t size) {
    NetworkUdp apart;
    if (apart.begin(port_)) send(apart, bytes, size);
    apart.stop();
  }
  void answerBy(AnswersApartTag<false>, const uint8_t* bytes, size_t size) {
    send(udp_, bytes, size);
  }
  void send(NetworkUdp& by, const uint8_t* bytes, size_t size) {
    by.beginPacket(udp_.remoteIP(), udp_.remotePort());
    by.write(bytes, size);
    by.endPacket();
  }

  NetworkUdp udp_;
  // The first octet is the lowest byte, as everywhere on Arduino.
  uint32_t group_;
  uint16_t port_;
  uint8_t opened_;
  uint8_t received_;
};

}  // namespace ros

#endif
