// The functions of Mbed 2 and of Mbed OS 6 that platform/mbed.h calls, for the registers of USART2 of an STM32F405.
#include <mbed.h>

#include "ros/platform/byte_ring.h"
#include "usart2.h"

namespace {

const uint32_t SYSTICK_LEFT = 0xe000e018;
volatile uint32_t ticks_ms = 0;

// qemu's UART delivers without a pause; at 57600 baud, 6 bytes arrive in a millisecond.
const uint8_t LINE_BYTES = 6;
uint8_t arrived = 0;

bool hasByte() { return arrived < LINE_BYTES && usart2::isSet(usart2::RECEIVED); }
uint8_t takeByte() {
  if (++arrived == LINE_BYTES) usart2::keepQuiet(usart2::RECEIVED);
  return static_cast<uint8_t>(at(usart2::BASE + usart2::DATA));
}

void onTick() {
  ticks_ms = ticks_ms + 1;
  arrived = 0;
  usart2::letInterrupt(usart2::RECEIVED);
}

// In qemu, the counter can start again a moment before its interrupt. The time must not go back then.
uint32_t now_us() {
  static uint32_t last_us = 0;
  uint32_t ms, left;
  do {
    ms = ticks_ms;
    left = at(SYSTICK_LEFT);
  } while (ms != ticks_ms);
  const uint32_t us = ms * 1000 + (usart2::TICK_CLOCKS - 1 - left) / (usart2::CLOCK_HZ / 1000000);
  if (static_cast<int32_t>(us - last_us) > 0) last_us = us;
  return last_us;
}

void send(uint8_t byte) {
  while (!usart2::isSet(usart2::TRANSMIT_EMPTY)) {
  }
  at(usart2::BASE + usart2::DATA) = byte;
}

}  // namespace

#if defined(MBED_MAJOR_VERSION)

static ros::ByteRing<256> ring;

static void keep() {
  while (hasByte()) ring.put(takeByte());
}

namespace mbed {

BufferedSerial::BufferedSerial(PinName, PinName, int baud) {
  usart2::start(onTick, keep, static_cast<uint32_t>(baud));
}
void BufferedSerial::set_baud(int baud) { usart2::setBaud(static_cast<uint32_t>(baud)); }
bool BufferedSerial::readable() const { return ring.count() > 0; }
ssize_t BufferedSerial::read(void* buffer, size_t) {
  *static_cast<uint8_t*>(buffer) = static_cast<uint8_t>(ring.take());
  return 1;
}
ssize_t BufferedSerial::write(const void* buffer, size_t length) {
  for (size_t i = 0; i < length; ++i) send(static_cast<const uint8_t*>(buffer)[i]);
  return static_cast<ssize_t>(length);
}

void Timer::start() { began_us_ = now_us(); }
std::chrono::microseconds Timer::elapsed_time() const { return std::chrono::microseconds(now_us() - began_us_); }

}  // namespace mbed

#else

static Callback<void()> on_received;
static bool is_attached = false;

static void callBack() {
  if (is_attached) {
    on_received();
  } else {
    takeByte();
  }
}

namespace mbed {

RawSerial::RawSerial(PinName, PinName, int baud) { usart2::start(onTick, callBack, static_cast<uint32_t>(baud)); }
int RawSerial::getc() { return takeByte(); }
int RawSerial::putc(int byte) {
  send(static_cast<uint8_t>(byte));
  return byte;
}
void SerialBase::baud(int baudrate) { usart2::setBaud(static_cast<uint32_t>(baudrate)); }
int SerialBase::readable() { return hasByte(); }
void SerialBase::attach(Callback<void()> function, IrqType) {
  on_received = function;
  is_attached = true;
}

void Timer::start() { began_us_ = now_us(); }
int Timer::read_us() { return static_cast<int>(now_us() - began_us_); }

}  // namespace mbed

#endif
