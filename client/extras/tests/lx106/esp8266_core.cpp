// The functions of the ESP8266's Arduino core that a node calls, for qemu's board lx60: its UART and cycle counter.
#include <Arduino.h>

extern "C" {
extern uint8_t bss_start[], bss_end[];
typedef void (*Constructor)();
extern Constructor __init_array_start[], __init_array_end[];

int __cxa_guard_acquire(uint8_t* guard) { return !*guard; }
void __cxa_guard_release(uint8_t* guard) { *guard = 1; }
void __cxa_pure_virtual() {
  for (;;) {
  }
}
void runProgram();
}

// The compiler's library has no division: it is in the ESP8266's ROM.
extern "C" uint32_t __udivsi3(uint32_t value, uint32_t divisor) {
  uint32_t quotient = 0, rest = 0;
  for (int bit = 31; bit >= 0; --bit) {
    rest = rest << 1 | (value >> bit & 1);
    if (rest < divisor) continue;
    rest -= divisor;
    quotient |= 1u << bit;
  }
  return quotient;
}
extern "C" uint32_t __umodsi3(uint32_t value, uint32_t divisor) { return value - __udivsi3(value, divisor) * divisor; }

void setup();
void loop();

void runProgram() {
  memset(bss_start, 0, static_cast<size_t>(bss_end - bss_start));
  for (Constructor* constructor = __init_array_start; constructor != __init_array_end; ++constructor) (*constructor)();
  setup();
  for (;;) {
    const unsigned long began_ms = millis();
    loop();
    while (millis() - began_ms < 5) {
    }
  }
}

// The cycles of qemu's lx106 in a millisecond.
static const uint32_t CYCLES = 10000;

unsigned long millis() {
  static uint32_t now_ms, counted;
  uint32_t cycles;
  __asm__ volatile("rsr.ccount %0" : "=r"(cycles));
  const uint32_t passed_ms = (cycles - counted) / CYCLES;
  counted += passed_ms * CYCLES;
  now_ms += passed_ms;
  return now_ms;
}

// A UART 16550, with one register in four bytes.
static volatile uint32_t* const UART = reinterpret_cast<uint32_t*>(0x9d050020);
enum Register { DATA = 0, FIFO_CONTROL = 2, LINE_STATUS = 5 };
enum LineStatus { RECEIVED = 0x01, TRANSMIT_EMPTY = 0x20 };
static const int FIFO_BYTES = 16;

size_t Print::write(const uint8_t*, size_t) { return 0; }
int Print::availableForWrite() { return 0; }

void HardwareSerial::begin(unsigned long) { UART[FIFO_CONTROL] = 0x01; }
int HardwareSerial::available() { return UART[LINE_STATUS] & RECEIVED; }
int HardwareSerial::read() { return available() ? static_cast<int>(UART[DATA] & 0xff) : -1; }
int HardwareSerial::peek() { return -1; }
int HardwareSerial::availableForWrite() { return UART[LINE_STATUS] & TRANSMIT_EMPTY ? FIFO_BYTES : 0; }
void HardwareSerial::flush() {}
size_t HardwareSerial::write(uint8_t byte) {
  while (!availableForWrite()) {
  }
  UART[DATA] = byte;
  return 1;
}
size_t HardwareSerial::write(const uint8_t* bytes, size_t count) {
  for (size_t i = 0; i < count; ++i) write(bytes[i]);
  return count;
}

HardwareSerial Serial;
