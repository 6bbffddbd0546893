#include "w5100.h"

#include <SPI.h>

namespace {

const uint8_t kRead = 0x0f;
const uint8_t kWrite = 0xf0;
const uint16_t kSentMemory = 0x4000;
const uint16_t kReceivedMemory = 0x6000;
const uint16_t kSocketMemory = 2048;
const uint8_t kReset = 0x80;

uint8_t select_pin = 10;
bool has_started = false;

}  // namespace

W5100Class W5100;

void W5100Class::select(uint8_t pin) { select_pin = pin; }

void W5100Class::init() {
  if (!has_started) {
    has_started = true;
    pinMode(select_pin, OUTPUT);
    digitalWrite(select_pin, HIGH);
    SPI.begin();
  }
  write(0x0000, kReset);
}

uint8_t W5100Class::exchange(uint8_t operation, uint16_t address, uint8_t byte) {
  SPI.beginTransaction(SPISettings(8000000, MSBFIRST, SPI_MODE0));
  digitalWrite(select_pin, LOW);
  SPI.transfer(operation);
  SPI.transfer(static_cast<uint8_t>(address >> 8));
  SPI.transfer(static_cast<uint8_t>(address));
  const uint8_t answer = SPI.transfer(byte);
  digitalWrite(select_pin, HIGH);
  SPI.endTransaction();
  return answer;
}

uint8_t W5100Class::read(uint16_t address) { return exchange(kRead, address, 0); }

void W5100Class::write(uint16_t address, uint8_t byte) { exchange(kWrite, address, byte); }

void W5100Class::read(uint16_t address, uint8_t* bytes, uint16_t count) {
  while (count--) *bytes++ = read(address++);
}

void W5100Class::write(uint16_t address, const uint8_t* bytes, uint16_t count) {
  while (count--) write(address++, *bytes++);
}

uint16_t W5100Class::read16(uint16_t address) {
  const uint8_t high = read(address);
  return static_cast<uint16_t>(high << 8 | read(address + 1));
}

void W5100Class::write16(uint16_t address, uint16_t value) {
  write(address, static_cast<uint8_t>(value >> 8));
  write(address + 1, static_cast<uint8_t>(value));
}

// Reads until two values are equal, because the chip may change the counter between its two bytes.
uint16_t W5100Class::read_counter(uint16_t address) {
  uint16_t value = read16(address), again;
  while ((again = read16(address)) != value) value = again;
  return value;
}

void W5100Class::execCmdSn(SOCKET s, SockCMD command) {
  write(at(s, 0x01), command);
  while (read(at(s, 0x01))) {}
}

void W5100Class::recv_data_processing(SOCKET s, uint8_t* bytes, uint16_t count, uint8_t peek) {
  uint16_t place = read16(at(s, 0x28));
  for (uint16_t i = 0; i < count; ++i, ++place)
    bytes[i] = read(static_cast<uint16_t>(kReceivedMemory + s * kSocketMemory + place % kSocketMemory));
  if (!peek) write16(at(s, 0x28), place);
}

void W5100Class::send_data_processing(SOCKET s, const uint8_t* bytes, uint16_t count) {
  uint16_t place = read16(at(s, 0x24));
  for (uint16_t i = 0; i < count; ++i, ++place)
    write(static_cast<uint16_t>(kSentMemory + s * kSocketMemory + place % kSocketMemory), bytes[i]);
  write16(at(s, 0x24), place);
}
