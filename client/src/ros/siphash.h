// SipHash-2-4 (Aumasson and Bernstein, 2012): a tag of 8 bytes that only holders of the key can make.
//
// Byte by byte: an 8-bit processor has no cheap way to add and turn words of 64 bits, and this is half as much code.
#ifndef ROS_SIPHASH_H_
#define ROS_SIPHASH_H_

#include <stdint.h>
#include <string.h>

#include "ros/flash.h"
#include "ros/inlining.h"

namespace ros {

// A key of 32 hexadecimal digits, as in the fleet's key file, that stays in program memory:
//
//   const ros::FleetKey KEY ROS_FLASH("000102030405060708090a0b0c0d0e0f");
class FleetKey {
 public:
  static const uint8_t BYTES = 32;

  // What SipHash starts with. A text with other characters does not compile.
  constexpr explicit FleetKey(const char (&hex)[33])
      : start{at(hex, 0), at(hex, 1), at(hex, 2), at(hex, 3), at(hex, 4), at(hex, 5), at(hex, 6), at(hex, 7),
              at(hex, 8), at(hex, 9), at(hex, 10), at(hex, 11), at(hex, 12), at(hex, 13), at(hex, 14), at(hex, 15),
              at(hex, 16), at(hex, 17), at(hex, 18), at(hex, 19), at(hex, 20), at(hex, 21), at(hex, 22), at(hex, 23),
              at(hex, 24), at(hex, 25), at(hex, 26), at(hex, 27), at(hex, 28), at(hex, 29), at(hex, 30), at(hex, 31)} {}

  // The key of a fleet without one.
  static const FleetKey& none() {
    static const FleetKey zeros ROS_FLASH("00000000000000000000000000000000");
    return zeros;
  }

  const uint8_t start[BYTES];

 private:
  static constexpr uint8_t at(const char* hex, uint8_t i) {
    // Each word with its last byte first.
    return static_cast<uint8_t>("uespemosmodnarodarenegylsetybdet"[i] ^ (digit(hex[i % 16 * 2]) << 4 | digit(hex[i % 16 * 2 + 1])));
  }
  static constexpr uint8_t digit(char c) {
    return static_cast<uint8_t>(c >= '0' && c <= '9'   ? c - '0'
                                : c >= 'a' && c <= 'f' ? c - 'a' + 10
                                : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                                       : not_a_hexadecimal_digit());
  }
  // Not to be called: the compiler names it.
  static int not_a_hexadecimal_digit();
};

class SipHash {
 public:
  static const uint8_t TAG_BYTES = 8;

  // Writes the tag of `length` bytes behind them.
  ROS_APART static void append(const FleetKey* key, uint8_t* bytes, uint16_t length) {
    uint8_t state[4 * WORD];
    ROS_COPY_FLASH(state, key->start, sizeof state);
    // The last word ends with the length, and takes the place of the tag.
    uint8_t* const tag = bytes + length;
    memset(tag, 0, TAG_BYTES);
    uint8_t* const last = tag + (WORD - 1 - static_cast<uint8_t>(length) % WORD);
    *last = static_cast<uint8_t>(length);
    do {
      combine(state + 3 * WORD, bytes);
      rounds(state, 2);
      combine(state, bytes);
      bytes += WORD;
    } while (bytes < last);
    state[2 * WORD] ^= 0xff;
    rounds(state, 4);
    memset(tag, 0, TAG_BYTES);
    for (uint8_t i = 0; i < sizeof state; i = static_cast<uint8_t>(i + WORD)) combine(tag, state + i);
  }

 private:
  static const uint8_t WORD = 8;

  ROS_APART static void combine(uint8_t* word, const uint8_t* with) {
    uint8_t count = WORD;
    do *word++ ^= *with++;
    while (--count);
  }

  ROS_APART static void rounds(uint8_t* state, uint8_t count) {
    do {
      mix(state, WORD, 64, true);
      mix(state + 2 * WORD, WORD, 4, false);
      mix(state, 3 * WORD, 128, false);
      mix(state + 2 * WORD, -WORD, 8, true);
    } while (--count);
  }

  // a += b, where b is `distance` bytes behind a; b = b turned left, xor a. Then the halves of a change places if `swaps`.
  //
  // A turn by seven bits at most is a multiplication; b is turned by `factor` (6, 2, 7 and 3 bits) and then by 7 once or
  // twice, which makes 13, 16, 21 and 17.
  ROS_APART static void mix(uint8_t* a, int8_t distance, uint8_t factor, bool swaps) {
    uint8_t* const b = a + distance;
    uint16_t sum = 0;
    for (uint8_t i = 0; i < WORD; ++i) a[i] = static_cast<uint8_t>(sum = static_cast<uint16_t>((sum >> 8) + a[i] + b[i]));
    uint8_t more = factor == 64 ? 1 : 2;
    do {
      uint8_t over = static_cast<uint8_t>(b[WORD - 1] * factor >> 8);
      uint8_t* next = b;
      for (uint8_t i = 0; i < WORD; ++i) {
        const uint16_t product = static_cast<uint16_t>(*next * factor + over);
        *next++ = static_cast<uint8_t>(product);
        over = static_cast<uint8_t>(product >> 8);
      }
      factor = 128;
    } while (more--);
    for (uint8_t i = 0; i < WORD / 2; ++i) {
      const uint8_t low = a[i], high = a[i + WORD / 2];
      b[i] = static_cast<uint8_t>(b[i] ^ low);
      b[i + WORD / 2] = static_cast<uint8_t>(b[i + WORD / 2] ^ high);
      if (swaps) {
        a[i] = high;
        a[i + WORD / 2] = low;
      }
    }
  }
};

}  // namespace ros

#endif
