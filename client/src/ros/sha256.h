// SHA-256 and HMAC-SHA256 (FIPS 180-4, RFC 2104), small rather than fast: 10 ms for 64 bytes on an Uno.
#ifndef ROS_SHA256_H_
#define ROS_SHA256_H_

#include <stddef.h>
#include <stdint.h>

#include "ros/flash.h"

namespace ros {

class Sha256 {
 public:
  static const uint8_t BLOCK_BYTES = 64;
  static const uint8_t DIGEST_BYTES = 32;

  Sha256() : bytes_(0) {
    static const uint32_t FIRST[8] ROS_FLASH = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                                0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    for (uint8_t i = 0; i < 8; ++i) state_[i] = word(FIRST + i);
  }

  void add(uint8_t byte) {
    const uint8_t at = static_cast<uint8_t>(bytes_++ % BLOCK_BYTES);
    uint32_t& filled = block_[at / 4];
    filled = filled << 8 | byte;
    if (at == BLOCK_BYTES - 1) mix();
  }
  void add(const void* bytes, size_t count) {
    const uint8_t* next = static_cast<const uint8_t*>(bytes);
    while (count--) add(*next++);
  }
  void add(const char* text) {
    while (*text) add(static_cast<uint8_t>(*text++));
  }

  // Computes the result; nothing can be added after this.
  void finish(uint8_t (&digest)[DIGEST_BYTES]) {
    // The length in bits has 64 bits on the wire, of which this code uses 32.
    const uint32_t bits = bytes_ * 8;
    const uint8_t zero = 0;
    add(static_cast<uint8_t>(0x80));
    while (bytes_ % BLOCK_BYTES != BLOCK_BYTES - 8) add(zero);
    for (uint8_t i = 0; i < 4; ++i) add(zero);
    for (uint8_t shift = 32; shift;) add(static_cast<uint8_t>(bits >> (shift -= 8)));
    for (uint8_t i = 0; i < DIGEST_BYTES; ++i) digest[i] = static_cast<uint8_t>(state_[i / 4] >> (24 - i % 4 * 8));
  }

 private:
  static uint32_t word(const uint32_t* address) {
#if defined(__AVR__)
    return pgm_read_dword(address);
#else
    return *address;
#endif
  }
  static uint32_t turned(uint32_t value, uint8_t bits) { return value >> bits | value << (32 - bits); }

  void mix() {
    static const uint32_t ROUND[64] ROS_FLASH = {
        0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
        0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
        0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
        0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
        0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
        0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
        0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
        0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};
    uint32_t s[8];
    for (uint8_t i = 0; i < 8; ++i) s[i] = state_[i];
    for (uint8_t round = 0; round < 64; ++round) {
      uint32_t& next = block_[round % 16];
      if (round >= 16) {
        const uint32_t early = block_[(round + 1) % 16], late = block_[(round + 14) % 16];
        next += (turned(early, 7) ^ turned(early, 18) ^ early >> 3) + block_[(round + 9) % 16] +
                (turned(late, 17) ^ turned(late, 19) ^ late >> 10);
      }
      const uint32_t first = s[7] + (turned(s[4], 6) ^ turned(s[4], 11) ^ turned(s[4], 25)) +
                             ((s[4] & s[5]) ^ (~s[4] & s[6])) + word(ROUND + round) + next;
      const uint32_t second =
          (turned(s[0], 2) ^ turned(s[0], 13) ^ turned(s[0], 22)) + ((s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]));
      for (uint8_t i = 7; i; --i) s[i] = s[i - 1];
      s[4] += first;
      s[0] = first + second;
    }
    for (uint8_t i = 0; i < 8; ++i) state_[i] += s[i];
  }

  uint32_t state_[8];
  uint32_t block_[16];
  uint32_t bytes_;
};

// The bytes of a text in ordinary memory, or of an F("...") in program memory.
class KeyText {
 public:
  KeyText() : text_(""), is_in_flash_(false) {}
  KeyText(const char* text) : text_(text), is_in_flash_(false) {}
  KeyText(const __FlashStringHelper* text) : text_(reinterpret_cast<const char*>(text)), is_in_flash_(true) {}

  size_t length() const {
    size_t count = 0;
    while (at(count)) ++count;
    return count;
  }
  uint8_t at(size_t index) const {
    return static_cast<uint8_t>(is_in_flash_ ? ROS_READ_FLASH(text_ + index) : text_[index]);
  }

 private:
  const char* text_;
  bool is_in_flash_;
};

class HmacSha256 {
 public:
  explicit HmacSha256(const KeyText& key) {
    const size_t length = key.length();
    for (uint8_t i = 0; i < Sha256::BLOCK_BYTES; ++i) key_[i] = i < length ? key.at(i) : 0;
    if (length > Sha256::BLOCK_BYTES) {
      Sha256 whole;
      for (size_t i = 0; i < length; ++i) whole.add(key.at(i));
      uint8_t digest[Sha256::DIGEST_BYTES];
      whole.finish(digest);
      for (uint8_t i = 0; i < Sha256::BLOCK_BYTES; ++i) key_[i] = i < Sha256::DIGEST_BYTES ? digest[i] : 0;
    }
    pad(0x36);
  }

  Sha256& text() { return hash_; }

  // Computes the result; nothing can be added after this.
  void finish(uint8_t (&digest)[Sha256::DIGEST_BYTES]) {
    hash_.finish(digest);
    hash_ = Sha256();
    pad(0x5c);
    hash_.add(digest, sizeof digest);
    hash_.finish(digest);
  }

 private:
  void pad(uint8_t with) {
    for (uint8_t i = 0; i < Sha256::BLOCK_BYTES; ++i) hash_.add(static_cast<uint8_t>(key_[i] ^ with));
  }

  uint8_t key_[Sha256::BLOCK_BYTES];
  Sha256 hash_;
};

}  // namespace ros

#endif
