// The functions of the RP2040's Arduino core that a node calls, for the chip's UART0 and timer.
#include <Arduino.h>

#include "registers.h"

void setup();
void loop();

int main() {
  setup();
  for (;;) {
    const unsigned long began_ms = millis();
    loop();
    while (millis() - began_ms < 5) {
    }
  }
}

unsigned long millis() {
  // The register counts microseconds since the start.
  const uint32_t TIMER_RAW_LOW = 0x40054028;
  static uint32_t now_ms, counted;
  const uint32_t passed_ms = (at(TIMER_RAW_LOW) - counted) / 1000;
  counted += passed_ms * 1000;
  now_ms += passed_ms;
  return now_ms;
}

static const uint32_t UART0 = 0x40034000;
enum Register { DATA = 0x00, FLAGS = 0x18, LINE_CONTROL = 0x2c, CONTROL = 0x30 };
enum Flag { RECEIVE_EMPTY = 0x10, TRANSMIT_FULL = 0x20 };
static const uint32_t EIGHT_BITS_WITH_FIFO = 0x70, ENABLED = 0x301;

size_t Print::write(const uint8_t*, size_t) { return 0; }
int Print::availableForWrite() { return 0; }

void HardwareSerial::begin(unsigned long, uint32_t, int8_t, int8_t) {
  at(UART0 + LINE_CONTROL) = EIGHT_BITS_WITH_FIFO;
  at(UART0 + CONTROL) = ENABLED;
}
int HardwareSerial::available() { return !(at(UART0 + FLAGS) & RECEIVE_EMPTY); }
int HardwareSerial::read() { return available() ? static_cast<int>(at(UART0 + DATA) & 0xff) : -1; }
int HardwareSerial::peek() { return -1; }
int HardwareSerial::availableForWrite() { return !(at(UART0 + FLAGS) & TRANSMIT_FULL); }
void HardwareSerial::flush() {}
size_t HardwareSerial::write(uint8_t byte) {
  while (!availableForWrite()) {
  }
  at(UART0 + DATA) = byte;
  return 1;
}
size_t HardwareSerial::write(const uint8_t* bytes, size_t count) {
  for (size_t i = 0; i < count; ++i) write(bytes[i]);
  return count;
}

HardwareSerial Serial;
