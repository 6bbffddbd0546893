// A UDP port in a multicast group that stays reachable: over any class with Arduino's UDP interface.
#ifndef ROS_MULTICAST_SOCKET_H_
#define ROS_MULTICAST_SOCKET_H_

#include <Arduino.h>
#include <stddef.h>
#include <stdint.h>

#if defined(ESP8266)
#include <ESP8266WiFi.h>
#endif

namespace ros {

// Whether answers need a socket of their own: in a group, a socket of a W5100 or W5500 sends only to the group.
template <class NetworkUdp>
struct AnswersApart {
  enum { value = 0 };
};
#if defined(ethernet_h_)  // Arduino's Ethernet library, which the sketch includes before
template <>
struct AnswersApart<EthernetUDP> {
  enum { value = 1 };
};
#endif
template <bool apart>
struct AnswersApartTag {};

// Network chips stop receiving a group after a while, and switches forget who is in it: a socket that receives nothing is
// opened again each second, any other once a minute. Classes without multicast receive by unicast only.
template <class NetworkUdp>
class MulticastSocket {
 public:
  MulticastSocket() : port_(0), opened_ms_(0), received_ms_(0) {}

  void begin(uint32_t group, uint16_t port) {
    group_ = group;
    port_ = port;
    open();
  }

  // The size of the next datagram, which `udp` then reads; 0 or less if there is none.
  int next() {
    const int size = udp_.parsePacket();
    if (size > 0) received_ms_ = millis();
    return size;
  }
  NetworkUdp& udp() { return udp_; }

  // Opens the socket again if it is due, or if `expected` is: there should have been a datagram.
  void watch(uint32_t now_ms, bool expected) {
    const uint32_t open_ms = now_ms - opened_ms_;
    if (expected || open_ms >= REJOIN_MS || (open_ms >= SILENCE_MS && now_ms - received_ms_ >= SILENCE_MS)) open();
  }

  void answer(const uint8_t* bytes, size_t size) {
    answerBy(AnswersApartTag<AnswersApart<NetworkUdp>::value>(), bytes, size);
  }

 private:
  static const uint16_t SILENCE_MS = 1000, REJOIN_MS = 60000;

  void open() {
    udp_.stop();
    if (!join(udp_, 0)) udp_.begin(port_);
    opened_ms_ = millis();
  }

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

  // From the group's port, which the sender then may use for unicast.
  void answerBy(AnswersApartTag<true>, const uint8_t* bytes, size_t size) {
    NetworkUdp apart;
    if (apart.begin(port_)) send(apart, bytes, size);
    apart.stop();
  }
  void answerBy(AnswersApartTag<false>, const uint8_t* bytes, size_t size) { send(udp_, bytes, size); }
  void send(NetworkUdp& by, const uint8_t* bytes, size_t size) {
    by.beginPacket(udp_.remoteIP(), udp_.remotePort());
    by.write(bytes, size);
    by.endPacket();
  }

  NetworkUdp udp_;
  // The first octet is the lowest byte, as everywhere on Arduino.
  uint32_t group_;
  uint16_t port_;
  uint32_t opened_ms_;
  uint32_t received_ms_;
};

}  // namespace ros

#endif
