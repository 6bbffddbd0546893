// A TCP connection to the host over any class with Arduino's Client interface; it reconnects whenever the link is
// lost.
#ifndef ROS_PLATFORM_ARDUINO_TCP_HARDWARE_H_
#define ROS_PLATFORM_ARDUINO_TCP_HARDWARE_H_

#include <Arduino.h>

#include "ros/platform/arduino_network.h"
#include "ros/platform/reconnection.h"

template <class NetworkClient>
class ArduinoTcpHardware {
 public:
  ArduinoTcpHardware() : port_(11411), asked_ms_(0) {}

  void setConnection(const IPAddress& server, int port = 11411) {
    server_ = server;
    port_ = static_cast<uint16_t>(port);
  }
  NetworkClient& client() { return client_; }
  bool connected() { return link_.isConnected(); }

  // Connects for the first time, with the time limit of the client; later spins try again.
  void init() {
    client_.stop();
    link_.reset();
    attempt();
  }

  int read() {
    if (link_.isOpen()) {
      const int byte = client_.read();
      if (byte >= 0) return byte;
    }
    watch();
    return -1;
  }

  void write(uint8_t* bytes, int count) {
    if (link_.isOpen()) client_.write(static_cast<const uint8_t*>(bytes), static_cast<size_t>(count));
  }

  bool relinked() { return link_.takeChange(); }
  void relink() {
    if (!link_.isConnected()) return;
    client_.stop();
    link_.lost(millis());
  }
  static bool isReliable() { return true; }
  unsigned long time() { return millis(); }

 private:
  // The time between checks of the connection: for a network chip, a check takes as long as reading many bytes.
  static const uint8_t WATCH_PERIOD_MS = 10;

  void watch() {
    const uint32_t now_ms = millis();
    if (link_.isConnected()) {
      if (static_cast<uint8_t>(now_ms - asked_ms_) < WATCH_PERIOD_MS) return;
      asked_ms_ = static_cast<uint8_t>(now_ms);
      if (!client_.connected()) relink();
    } else if (link_.isDue(now_ms)) {
      attempt();
    }
  }

  void attempt() {
    const uint32_t began_ms = millis();
    if (client_.connect(server_, port_) > 0) {
      sendAtOnce(client_, 0);
      link_.succeeded();
    } else {
      client_.stop();
      link_.failed(began_ms, millis());
    }
  }

  // For boards that would otherwise delay small packets.
  template <class C>
  static auto sendAtOnce(C& client, int) -> decltype(client.setNoDelay(true), void()) {
    client.setNoDelay(true);
  }
  template <class C>
  static void sendAtOnce(C&, long) {}

  NetworkClient client_;
  IPAddress server_;
  uint16_t port_;
  uint8_t asked_ms_;
  ros::Reconnection link_;
};

#endif
