// The part of an Arduino core that the library uses: Print, Stream, and each core's own serial port classes.
#ifndef STUB_ARDUINO_H_
#define STUB_ARDUINO_H_

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef uint8_t byte;
#define LOW 0
#define HIGH 1
#define OUTPUT 1
#define DEG_TO_RAD 0.017453292519943295
unsigned long millis();
void delay(unsigned long);
void pinMode(uint8_t, uint8_t);
void digitalWrite(uint8_t, uint8_t);
void analogWrite(uint8_t, int);

class __FlashStringHelper;

class Print {
 public:
  virtual size_t write(uint8_t) = 0;
  virtual size_t write(const uint8_t* buffer, size_t size);
#if !defined(__OPENCR__)
  virtual int availableForWrite();
#endif
  virtual void flush() = 0;
};

class Stream : public Print {
 public:
  virtual int available() = 0;
  virtual int read() = 0;
  virtual int peek() = 0;
};

#define STUB_STREAM                                       \
  size_t write(uint8_t) override;                         \
  size_t write(const uint8_t* buffer, size_t) override;   \
  int available() override;                               \
  int read() override;                                    \
  int peek() override;                                    \
  void flush() override;

class IPAddress {
 public:
  IPAddress();
  IPAddress(uint8_t, uint8_t, uint8_t, uint8_t);
  IPAddress(uint32_t);
  operator uint32_t() const;
  bool operator==(const IPAddress&) const;
};

class Client : public Stream {
 public:
  virtual int connect(IPAddress, uint16_t) = 0;
  virtual int connect(const char*, uint16_t) = 0;
  using Print::write;
  using Stream::read;
  virtual int read(uint8_t*, size_t) = 0;
  virtual void stop() = 0;
  virtual uint8_t connected() = 0;
  virtual operator bool() = 0;
};

#define STUB_CLIENT                              \
  STUB_STREAM                                    \
  int connect(IPAddress, uint16_t) override;     \
  int connect(const char*, uint16_t) override;   \
  int read(uint8_t*, size_t) override;           \
  void stop() override;                          \
  uint8_t connected() override;                  \
  operator bool() override;

class UDP : public Stream {
 public:
  virtual uint8_t begin(uint16_t) = 0;
#if !defined(ESP8266) && !defined(STUB_UDP_WITHOUT_MULTICAST)
  virtual uint8_t beginMulticast(IPAddress, uint16_t);
#endif
  virtual void stop() = 0;
  virtual int beginPacket(IPAddress, uint16_t) = 0;
  virtual int beginPacket(const char*, uint16_t) = 0;
  virtual int endPacket() = 0;
  virtual int parsePacket() = 0;
  using Stream::read;
  virtual int read(unsigned char*, size_t) = 0;
  virtual IPAddress remoteIP() = 0;
  virtual uint16_t remotePort() = 0;
};

#define STUB_UDP                                     \
  STUB_STREAM                                        \
  uint8_t begin(uint16_t) override;                  \
  void stop() override;                              \
  int beginPacket(IPAddress, uint16_t) override;     \
  int beginPacket(const char*, uint16_t) override;   \
  int endPacket() override;                          \
  int parsePacket() override;                        \
  int read(unsigned char*, size_t) override;         \
  IPAddress remoteIP() override;                     \
  uint16_t remotePort() override;

#if defined(ARDUINO_ARCH_SAMD)
class HardwareSerial : public Stream {
 public:
  virtual void begin(unsigned long) = 0;
  virtual void begin(unsigned long, uint16_t) = 0;
};
class Uart : public HardwareSerial {
 public:
  void begin(unsigned long) override;
  void begin(unsigned long, uint16_t) override;
  int availableForWrite() override;
  STUB_STREAM
};
class Serial_ : public Stream {
 public:
  void begin(uint32_t);
  void begin(uint32_t, uint8_t);
  int availableForWrite() override;
  STUB_STREAM
};
extern Uart Serial1;
extern Serial_ SerialUSB;
#define Serial SerialUSB
#elif defined(ARDUINO_UNOWIFIR4)
namespace arduino {
class HardwareSerial : public Stream {
 public:
  virtual void begin(unsigned long) = 0;
  virtual void begin(unsigned long, uint16_t) = 0;
};
}  // namespace arduino
class UART : public arduino::HardwareSerial {
 public:
  void begin(unsigned long) override;
  void begin(unsigned long, uint16_t) override;
  int availableForWrite() override;
  STUB_STREAM
};
extern UART _UART1_;
#define Serial _UART1_
#elif defined(_SAM3XA_)
class HardwareSerial : public Stream {};
class UARTClass : public HardwareSerial {
 public:
  void begin(const uint32_t);
  int availableForWrite();
  STUB_STREAM
};
extern UARTClass Serial;
#elif defined(TEENSYDUINO)
class HardwareSerial : public Stream {
 public:
  void begin(uint32_t, uint16_t format = 0);
  int availableForWrite() override;
  STUB_STREAM
};
class usb_serial_class : public Stream {
 public:
  void begin(long);
  int availableForWrite() override;
  STUB_STREAM
};
extern usb_serial_class Serial;
extern HardwareSerial Serial1;
#elif defined(__OPENCR__) || defined(__STM32F1__)
class USBSerial : public Stream {
 public:
  void begin(uint32_t);
  void begin(uint32_t, uint8_t);
  STUB_STREAM
};
extern USBSerial Serial;
class HardwareSerial : public Stream {
 public:
  void begin(uint32_t);
  STUB_STREAM
};
extern HardwareSerial Serial1;
#elif defined(ESP8266)
enum SerialConfig { SERIAL_8N1 };
class HardwareSerial : public Stream {
 public:
  void begin(unsigned long);
  void begin(unsigned long, SerialConfig);
  int availableForWrite() override;
  STUB_STREAM
};
extern HardwareSerial Serial;
#else
// ESP32, STM32 and RP2040 cores.
class HardwareSerial : public Stream {
 public:
  void begin(unsigned long, uint32_t config = 0, int8_t rx = -1, int8_t tx = -1);
  int availableForWrite();
  STUB_STREAM
};
extern HardwareSerial Serial;
extern HardwareSerial Serial1;
#endif

#endif
