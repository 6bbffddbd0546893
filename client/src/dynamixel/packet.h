// Packets of the DYNAMIXEL protocol 2.0 as bytes: no clock and no port.
//
//   ff ff fd 00 | id | length, 2 bytes | instruction | parameters | CRC, 2 bytes
//
// Numbers are little endian. The length counts the bytes from the instruction to the CRC. A status packet, the answer
// of a servo, has the instruction 0x55, and its first parameter is the error. After each ff ff fd that occurs from the
// instruction to the last parameter, an additional fd is sent (byte stuffing), so that a header never occurs there.
#ifndef DYNAMIXEL_PACKET_H_
#define DYNAMIXEL_PACKET_H_

#include <stddef.h>
#include <stdint.h>

namespace dynamixel {

enum Instruction : uint8_t {
  PING = 0x01,
  READ = 0x02,
  WRITE = 0x03,
  REG_WRITE = 0x04,
  ACTION = 0x05,
  REBOOT = 0x08,
  STATUS = 0x55,
  SYNC_READ = 0x82,
  SYNC_WRITE = 0x83
};

// The errors that a servo reports in a status packet, without ALERT.
enum ServoError : uint8_t {
  NO_ERROR = 0,
  RESULT_FAIL = 1,
  INSTRUCTION_ERROR = 2,
  CRC_ERROR = 3,
  DATA_RANGE_ERROR = 4,
  DATA_LENGTH_ERROR = 5,
  DATA_LIMIT_ERROR = 6,
  ACCESS_ERROR = 7
};
// Added to the error while the servo has a hardware error: address 70 shows which.
const uint8_t ALERT = 0x80;
const uint8_t BROADCAST_ID = 0xfe;

// CRC-16 with the polynomial 0x8005 and the start value 0, most significant bit first.
inline uint16_t addToCrc(uint16_t crc, uint8_t byte) {
  crc = static_cast<uint16_t>(crc ^ byte << 8);
  for (uint8_t bit = 0; bit < 8; ++bit) {
    crc = static_cast<uint16_t>(crc & 0x8000 ? crc << 1 ^ 0x8005 : crc << 1);
  }
  return crc;
}

// Detects the fd that byte stuffing adds.
class Stuffing {
 public:
  Stuffing() : matched_(0) {}
  // Returns whether an added fd follows this byte. Call it for each byte except the added ones.
  bool follows(uint8_t byte) {
    if (matched_ == 2 && byte == 0xfd) {
      matched_ = 0;
      return true;
    }
    matched_ = byte != 0xff ? 0 : matched_ < 2 ? matched_ + 1 : 2;
    return false;
  }

 private:
  uint8_t matched_;
};

// Writes a packet of up to CAPACITY bytes.
template <size_t CAPACITY>
class PacketWriter {
 public:
  void begin(uint8_t id, uint8_t instruction) {
    static const uint8_t header[] = {0xff, 0xff, 0xfd, 0x00};
    size_ = 0;
    fits_ = true;
    stuffing_ = Stuffing();
    for (uint8_t i = 0; i < sizeof header; ++i) put(header[i]);
    put(id);
    put(0);  // the length, which `finish` writes
    put(0);
    add(instruction);
  }
  void add(uint8_t byte) {
    put(byte);
    if (stuffing_.follows(byte)) put(0xfd);
  }
  void add16(uint16_t number) { addNumber(number, 2); }
  // Adds the lowest `size` bytes of a number.
  void addNumber(uint32_t number, uint8_t size) {
    for (; size > 0; --size, number >>= 8) add(static_cast<uint8_t>(number));
  }

  // Adds length and CRC. Returns false if the packet is too long.
  bool finish() {
    const size_t length = size_ - 5;
    if (!fits_ || size_ + 2 > CAPACITY) return false;
    bytes_[5] = static_cast<uint8_t>(length);
    bytes_[6] = static_cast<uint8_t>(length >> 8);
    uint16_t crc = 0;
    for (size_t i = 0; i < size_; ++i) crc = addToCrc(crc, bytes_[i]);
    put(static_cast<uint8_t>(crc));
    put(static_cast<uint8_t>(crc >> 8));
    return true;
  }
  const uint8_t* bytes() const { return bytes_; }
  size_t size() const { return size_; }

 private:
  void put(uint8_t byte) {
    fits_ = fits_ && size_ < CAPACITY;
    if (fits_) bytes_[size_++] = byte;
  }

  uint8_t bytes_[CAPACITY];
  size_t size_;
  bool fits_;
  Stuffing stuffing_;
};

// Finds packets with up to CAPACITY parameters in received bytes.
template <size_t CAPACITY>
class PacketReader {
 public:
  PacketReader() : damaged_(0) { restart(); }

  // Discards a packet that has not ended.
  void restart() { position_ = 0; }

  // Returns true if this byte completes an undamaged packet, which stays valid until the next call.
  bool push(uint8_t byte) {
    if (position_ < HEADER_BYTES) {
      findHeader(byte);
      return false;
    }
    const size_t index = position_++;
    if (index >= 5 + 2 + left_) return checkCrc(index, byte);
    crc_ = addToCrc(crc_, byte);
    if (index == 4) {
      id_ = byte;
    } else if (index == 5) {
      left_ = byte;
    } else if (index == 6) {
      left_ |= static_cast<size_t>(byte) << 8;
      // The shortest packet has an instruction and a CRC. Stuffing can add a third.
      if (left_ < 3 || left_ > 3 + CAPACITY + CAPACITY / 3 + 1) return drop();
      left_ -= 2;
    } else if (index == 7) {
      instruction_ = byte;
      stuffing_.follows(byte);
    } else if (is_stuffing_) {
      is_stuffing_ = false;
    } else {
      if (size_ == CAPACITY) return drop();
      parameters_[size_++] = byte;
      is_stuffing_ = stuffing_.follows(byte);
    }
    return false;
  }

  uint8_t id() const { return id_; }
  uint8_t instruction() const { return instruction_; }
  const uint8_t* parameters() const { return parameters_; }
  size_t size() const { return size_; }
  // The number of packets dropped since the start because of their CRC or length.
  uint16_t damaged() const { return damaged_; }

 private:
  static const size_t HEADER_BYTES = 4;

  void findHeader(uint8_t byte) {
    static const uint8_t header[HEADER_BYTES] = {0xff, 0xff, 0xfd, 0x00};
    if (byte != header[position_]) {
      // After ff ff, another ff leaves ff ff.
      if (byte != 0xff) position_ = 0;
      else if (position_ != 2) position_ = 1;
      return;
    }
    if (++position_ < HEADER_BYTES) return;
    crc_ = 0;
    for (uint8_t i = 0; i < HEADER_BYTES; ++i) crc_ = addToCrc(crc_, header[i]);
    size_ = 0;
    left_ = CAPACITY + 3;
    is_stuffing_ = false;
    stuffing_ = Stuffing();
  }

  bool checkCrc(size_t index, uint8_t byte) {
    if (index == 5 + 2 + left_) {
      if (byte != static_cast<uint8_t>(crc_)) return drop();
      return false;
    }
    if (byte != static_cast<uint8_t>(crc_ >> 8)) return drop();
    restart();
    return true;
  }

  bool drop() {
    ++damaged_;
    restart();
    return false;
  }

  size_t position_;  // of the next byte in the packet
  size_t left_;      // bytes from the instruction to the last parameter
  size_t size_;
  uint16_t crc_;
  uint16_t damaged_;
  uint8_t id_;
  uint8_t instruction_;
  bool is_stuffing_;
  Stuffing stuffing_;
  uint8_t parameters_[CAPACITY];
};

}  // namespace dynamixel

#endif
