// Any Arduino serial port: hardware UART, USB, SoftwareSerial, or another Stream.
//
// The port is `Serial`, unless the sketch defines another before <ros.h>: USE_TEENSY_HW_SERIAL and USE_STM32_HW_SERIAL
// choose Serial1; boards whose USB is their Serial (Leonardo, Micro, Zero, MKR) use Serial1 unless USE_USBCON is
// defined, as sketches for them expect; SERIAL_PORT names any other. A class of the sketch can also name it:
//
//   class NewHardware : public ArduinoHardware {
//    public:
//     NewHardware() : ArduinoHardware(&Serial1, 57600) {}
//   };
//   ros::NodeHandle_<NewHardware> nh;
#ifndef ROS_PLATFORM_ARDUINO_H_
#define ROS_PLATFORM_ARDUINO_H_

#if ARDUINO >= 100
#include <Arduino.h>
#else
#include <WProgram.h>
#endif

#include "ros/platform/serial_port.h"

#if !defined(SERIAL_PORT)
#if defined(USE_TEENSY_HW_SERIAL) || defined(USE_STM32_HW_SERIAL)
#define SERIAL_PORT Serial1
#elif defined(USBCON) && !defined(USE_USBCON) && (defined(__AVR__) || defined(ARDUINO_ARCH_SAMD))
#define SERIAL_PORT Serial1
#else
#define SERIAL_PORT Serial
#endif
#endif

#if !defined(SERIAL_CLASS)
namespace ros {
template <class Port>
struct PortClass {
  typedef Port type;
};
template <class Port>
struct PortClass<Port&> {
  typedef Port type;
};
typedef PortClass<decltype(SERIAL_PORT)>::type SerialClass;
}  // namespace ros
#define SERIAL_CLASS ros::SerialClass
#endif

namespace ros {

class ArduinoSerial {
 public:
  ArduinoSerial() : iostream(&SERIAL_PORT), baud_(57600) {}
  template <class Port>
  ArduinoSerial(Port* io, long baud = 57600) : iostream(io), baud_(baud) {}

  // Takes effect with the next initNode.
  void setBaud(long baud) { baud_ = baud; }
  long getBaud() const { return baud_; }
  template <class Port>
  void setPort(Port* io) {
    iostream = io;
  }

  void init() { iostream.begin(static_cast<unsigned long>(baud_)); }
  int read() { return iostream.read(); }
  void write(uint8_t* bytes, int count) { iostream.write(bytes, count); }
  int writable() { return iostream.writable(); }
  unsigned long time() { return millis(); }

 protected:
  SerialPort<SERIAL_CLASS> iostream;
  long baud_;
};

}  // namespace ros

#if (defined(ESP8266) || defined(ESP32)) && !defined(ESP_SERIAL)
#include "ros/platform/arduino_esp.h"
#else
class ArduinoHardware : public ros::ArduinoSerial {
 public:
  ArduinoHardware() {}
  template <class Port>
  ArduinoHardware(Port* io, long baud = 57600) : ros::ArduinoSerial(io, baud) {}
};
#endif

#endif
