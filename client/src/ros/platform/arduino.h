// Any Arduino serial port: hardware UART, USB CDC, SoftwareSerial, Teensy, STM32, ESP.
//
// SERIAL_CLASS and SERIAL_PORT may be defined before <ros.h>; the switches of the established library (USE_USBCON,
// USE_TEENSY_HW_SERIAL, USE_STM32_HW_SERIAL) choose them too.
#ifndef ROS_PLATFORM_ARDUINO_H_
#define ROS_PLATFORM_ARDUINO_H_

#if ARDUINO >= 100
#include <Arduino.h>
#else
#include <WProgram.h>
#endif

#if !defined(SERIAL_CLASS)
#if defined(TEENSYDUINO) || defined(CORE_TEENSY)
#if defined(USE_TEENSY_HW_SERIAL)
#include <HardwareSerial.h>
#define SERIAL_CLASS HardwareSerial
#define SERIAL_PORT Serial1
#else
#include <usb_serial.h>
#define SERIAL_CLASS usb_serial_class
#endif
#elif defined(USE_STM32_HW_SERIAL)
#define SERIAL_CLASS HardwareSerial
#define SERIAL_PORT Serial1
#elif defined(_SAMD21_) || defined(ARDUINO_ARCH_SAMD)
#define SERIAL_CLASS Serial_
#if defined(SerialUSB)
#define SERIAL_PORT SerialUSB
#endif
#elif defined(USE_USBCON) && defined(USBCON)
#define SERIAL_CLASS Serial_
#elif defined(__AVR__) && defined(USBCON)
#define SERIAL_CLASS Serial_
#elif defined(__AVR__)
#include <HardwareSerial.h>
#define SERIAL_CLASS HardwareSerial
#else
#define SERIAL_CLASS Stream
#endif
#endif

#if !defined(SERIAL_PORT)
#define SERIAL_PORT Serial
#endif

class ArduinoHardware {
 public:
  explicit ArduinoHardware(SERIAL_CLASS* io, long baud = 57600) : iostream(io), baud_(baud) {}
  ArduinoHardware() : iostream(&SERIAL_PORT), baud_(57600) {}

  void setBaud(long baud) { baud_ = baud; }
  int getBaud() { return static_cast<int>(baud_); }
  void setPort(SERIAL_CLASS* io) { iostream = io; }

  void init() { iostream->begin(baud_); }
  int read() { return iostream->read(); }
  void write(uint8_t* bytes, int count) { iostream->write(bytes, count); }
  int writable() { return iostream->availableForWrite(); }
  unsigned long time() { return millis(); }

 protected:
  SERIAL_CLASS* iostream;
  long baud_;
};

#endif
