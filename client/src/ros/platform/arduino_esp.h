// ESP8266 and ESP32: the serial port, or Wi-Fi once the sketch calls setConnection. Sketches for the established
// library call it without defining ROSSERIAL_ARDUINO_TCP: that library defines the macro for these boards. If the
// sketch defines ESP_SERIAL, it has only the serial port.
#ifndef ROS_PLATFORM_ARDUINO_ESP_H_
#define ROS_PLATFORM_ARDUINO_ESP_H_

#include "ros/platform/arduino_tcp_hardware.h"

namespace ros {

// The network as virtual functions: a sketch that does not call setConnection contains none of the network's code.
class Network {
 public:
  virtual void setConnection(const IPAddress& server, int port) = 0;
  virtual void init() = 0;
  virtual int read() = 0;
  virtual void write(uint8_t* bytes, int count) = 0;
  virtual bool relinked() = 0;
  virtual void relink() = 0;

 protected:
  ~Network() {}
};

template <class Hardware>
class NetworkOf final : public Network {
 public:
  void setConnection(const IPAddress& server, int port) override { hardware_.setConnection(server, port); }
  void init() override { hardware_.init(); }
  int read() override { return hardware_.read(); }
  void write(uint8_t* bytes, int count) override { hardware_.write(bytes, count); }
  bool relinked() override { return hardware_.relinked(); }
  void relink() override { hardware_.relink(); }

 private:
  Hardware hardware_;
};

}  // namespace ros

class ArduinoHardware : public ros::ArduinoSerial {
 public:
  ArduinoHardware() : network_(nullptr) {}
  template <class Port>
  ArduinoHardware(Port* io, long baud = 57600) : ros::ArduinoSerial(io, baud), network_(nullptr) {}

  // Takes effect with the next initNode.
  void setConnection(const IPAddress& server, int port = 11411) {
    if (!network_) network_ = new ros::NetworkOf<ArduinoTcpHardware<ros::BoardClient> >;
    network_->setConnection(server, port);
  }
  IPAddress getLocalIP() { return ros::boardAddress(); }

  void init() {
    if (network_) return network_->init();
    ros::ArduinoSerial::init();
  }
  int read() { return network_ ? network_->read() : ros::ArduinoSerial::read(); }
  void write(uint8_t* bytes, int count) {
    if (network_) return network_->write(bytes, count);
    ros::ArduinoSerial::write(bytes, count);
  }
  // A client accepts any number of bytes.
  int writable() { return network_ ? 0x7fff : ros::ArduinoSerial::writable(); }
  bool relinked() { return network_ && network_->relinked(); }
  void relink() {
    if (network_) network_->relink();
  }
  // The network is TCP.
  bool isReliable() const { return network_ != nullptr; }

 private:
  ros::Network* network_;
};

#endif
