// SipHash-2-4 (Aumasson and Bernstein, 2012): a tag of 8 bytes that only holders of the key can make.
//
// An AVR has no short instructions to add and rotate 64-bit words. Therefore its code is assembly: a compiler makes
// twice as much code.
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

  // The initial state of SipHash. A text with other characters does not compile.
  constexpr explicit FleetKey(const char (&hex)[33])
      : start{at(hex, 0), at(hex, 1), at(hex, 2), at(hex, 3), at(hex, 4), at(hex, 5), at(hex, 6), at(hex, 7),
              at(hex, 8), at(hex, 9), at(hex, 10), at(hex, 11), at(hex, 12), at(hex, 13), at(hex, 14), at(hex, 15),
              at(hex, 16), at(hex, 17), at(hex, 18), at(hex, 19), at(hex, 20), at(hex, 21), at(hex, 22), at(hex, 23),
              at(hex, 24), at(hex, 25), at(hex, 26), at(hex, 27), at(hex, 28), at(hex, 29), at(hex, 30), at(hex, 31)} {}

  // The key for a fleet that has no key file.
  static const FleetKey& none() {
    static const FleetKey zeros ROS_FLASH("00000000000000000000000000000000");
    return zeros;
  }

  const uint8_t start[BYTES];

 private:
  static constexpr uint8_t at(const char* hex, uint8_t i) {
    // SipHash's constants, with the bytes of each word in reverse order, as in memory.
    return static_cast<uint8_t>("uespemosmodnarodarenegylsetybdet"[i] ^ (digit(hex[i % 16 * 2]) << 4 | digit(hex[i % 16 * 2 + 1])));
  }
  static constexpr uint8_t digit(char c) {
    return static_cast<uint8_t>(c >= '0' && c <= '9'   ? c - '0'
                                : c >= 'a' && c <= 'f' ? c - 'a' + 10
                                : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                                       : not_a_hexadecimal_digit());
  }
  // Never called; the name appears in the compiler's error message.
  static int not_a_hexadecimal_digit();
};

class SipHash {
 public:
  static const uint8_t TAG_BYTES = 8;

  // XORs the 8 bytes after the message with the tag of the message's `length` bytes: zeros become the tag, and a valid
  // tag becomes zeros. Returns 0 if the 8 bytes are zeros now. The time does not depend on the values.
#if defined(__AVR__)
  ROS_APART static uint8_t combine(const FleetKey* key, uint8_t* bytes, uint16_t length) {
    // v0 to v3, then a copy of the 8 bytes after the message: their place holds the message's last word meanwhile. It
    // is static, because a stack frame takes more code.
    static uint8_t state[5 * 8];
    uint8_t *x, *z, count, byte, over, factor = static_cast<uint8_t>(length);
    const uint8_t* const tag = bytes + length;
    asm volatile(
        "ldi r26, lo8(%[state])\n\t"
        "ldi r27, hi8(%[state])\n\t"
        "ldi %[count], 32\n"
        "1: lpm r0, Z+\n\t"
        "st X+, r0\n\t"
        "dec %[count]\n\t"
        "brne 1b\n\t"
        "movw r30, %[tag]\n\t"
        "ldi %[count], 8\n"
        "1: ld r0, Z\n\t"
        "st X+, r0\n\t"
        "st Z+, r1\n\t"
        "dec %[count]\n\t"
        "brne 1b\n\t"
        // The last word ends with the length.
        "mov %[byte], %[factor]\n\t"
        "andi %[byte], 7\n\t"
        "sub r30, %[byte]\n\t"
        "sbc r31, r1\n\t"
        "st -Z, %[factor]\n\t"
        "movw r30, r26\n\t"
        "sbiw r30, 40\n"
        // Each word: v3 ^= word, two rounds, v0 ^= word. Z points to v0 here.
        "1: adiw r30, 24\n\t"
        "movw r26, %[next]\n\t"
        "rcall 8f\n\t"
        "sbiw r30, 24\n\t"
        "rcall 2f\n\t"
        "movw r26, %[next]\n\t"
        "rcall 8f\n\t"
        "sbiw r30, 8\n\t"
        "movw %[next], r26\n\t"
        "cp %A[tag], %A[next]\n\t"
        "cpc %B[tag], %B[next]\n\t"
        "brsh 1b\n\t"
        "ldd r0, Z+16\n\t"
        "com r0\n\t"
        "std Z+16, r0\n\t"
        "adiw r30, 8\n\t"
        "rcall 2f\n\t"
        "adiw r30, 8\n\t"
        "rcall 2f\n\t"
        "movw r26, %[tag]\n\t"
        "ldi %[count], 8\n\t"
        "clr %[over]\n"
        "1: ld r0, Z+\n\t"
        "ldd %[byte], Z+7\n\t"
        "eor r0, %[byte]\n\t"
        "ldd %[byte], Z+15\n\t"
        "eor r0, %[byte]\n\t"
        "ldd %[byte], Z+23\n\t"
        "eor r0, %[byte]\n\t"
        "ldd %[byte], Z+31\n\t"
        "eor r0, %[byte]\n\t"
        "st X+, r0\n\t"
        "or %[over], r0\n\t"
        "dec %[count]\n\t"
        "brne 1b\n\t"
        "rjmp 9f\n"
        // Two rounds. Z points to v1 at first, and to v0 at the end. In each step, X points to a, and Z to b.
        "2: rcall 2f\n\t"
        "adiw r30, 8\n"
        "2: movw r26, r30\n\t"
        "sbiw r26, 8\n\t"
        "ldi %[factor], 64\n\t"
        "rcall 3f\n\t"  // v0, v1: 13 bits
        "adiw r26, 8\n\t"
        "adiw r30, 8\n\t"
        "ldi %[factor], 4\n\t"
        "rcall 5f\n\t"  // v2, v3: 16 bits
        "sbiw r26, 24\n\t"
        "sbiw r30, 8\n\t"
        "ldi %[factor], 128\n\t"
        "rcall 5f\n\t"  // v0, v3: 21 bits
        "adiw r26, 8\n\t"
        "sbiw r30, 24\n\t"
        "ldi %[factor], 8\n\t"
        "rcall 3f\n\t"  // v2, v1: 17 bits
        "sbiw r30, 16\n\t"
        "ret\n"
        // A step that also swaps the two halves of `a`.
        "3: rcall 5f\n\t"
        "push r30\n\t"
        "push r31\n\t"
        "movw r30, r26\n\t"
        "sbiw r30, 8\n\t"
        "ldi %[count], 4\n"
        "4: ld r0, Z\n\t"
        "ldd %[byte], Z+4\n\t"
        "std Z+4, r0\n\t"
        "st Z+, %[byte]\n\t"
        "dec %[count]\n\t"
        "brne 4b\n\t"
        "pop r31\n\t"
        "pop r30\n\t"
        "ret\n"
        // A step: a += b
        "5: ldi %[count], 8\n\t"
        "clc\n"
        "6: ld r0, X\n\t"
        "ld %[byte], Z+\n\t"
        "adc r0, %[byte]\n\t"
        "st X+, r0\n\t"
        "dec %[count]\n\t"
        "brne 6b\n\t"
        "sbiw r26, 8\n\t"
        // Rotates b left: by `factor`, and then by 7 bits once or twice.
        "bst %[factor], 6\n\t"
        "rcall 6f\n\t"
        "ldi %[factor], 128\n\t"
        "brts 4f\n\t"
        "rcall 6f\n"
        "4: rcall 6f\n\t"
        "sbiw r30, 8\n"
        // b ^= a
        "8: ldi %[count], 8\n"
        "1: ld r0, X+\n\t"
        "ld %[byte], Z\n\t"
        "eor %[byte], r0\n\t"
        "st Z+, %[byte]\n\t"
        "dec %[count]\n\t"
        "brne 1b\n\t"
        "ret\n"
        // One rotation. Z points to the byte after b.
        "6: ld %[byte], -Z\n\t"
        "sbiw r30, 7\n\t"
        "mul %[byte], %[factor]\n\t"
        "ldi %[count], 8\n"
        "7: mov %[over], r1\n\t"
        "ld %[byte], Z\n\t"
        "mul %[byte], %[factor]\n\t"
        "add r0, %[over]\n\t"
        "st Z+, r0\n\t"
        "dec %[count]\n\t"
        "brne 7b\n\t"
        "ret\n"
        "9: clr r1"
        : [x] "=&x"(x), [z] "=z"(z), [next] "+r"(bytes), [count] "=&d"(count), [byte] "=&d"(byte), [over] "=&r"(over),
          [factor] "+d"(factor)
        : "z"(key->start), [tag] "r"(tag), [state] "i"(state)
        : "memory");
    return over;
  }
#else
  static uint8_t combine(const FleetKey* key, uint8_t* bytes, size_t length) {
    uint64_t state[4], word;
    memcpy(state, key->start, sizeof state);
    size_t done = 0;
    for (; length - done >= sizeof word; done += sizeof word) {
      memcpy(&word, bytes + done, sizeof word);
      absorb(state, word);
    }
    // The last word ends with the length.
    word = static_cast<uint64_t>(length) << 56;
    memcpy(&word, bytes + done, length - done);
    absorb(state, word);
    state[2] ^= 0xff;
    for (int i = 0; i < 4; ++i) round(state);
    memcpy(&word, bytes + length, sizeof word);
    word ^= state[0] ^ state[1] ^ state[2] ^ state[3];
    memcpy(bytes + length, &word, sizeof word);
    return word != 0;
  }

 private:
  static void absorb(uint64_t* v, uint64_t word) {
    v[3] ^= word;
    round(v);
    round(v);
    v[0] ^= word;
  }
  static void round(uint64_t* v) {
    step(v[0], v[1], 13);
    v[0] = left(v[0], 32);
    step(v[2], v[3], 16);
    step(v[0], v[3], 21);
    step(v[2], v[1], 17);
    v[2] = left(v[2], 32);
  }
  static void step(uint64_t& a, uint64_t& b, int bits) {
    a += b;
    b = left(b, bits) ^ a;
  }
  static uint64_t left(uint64_t word, int bits) { return word << bits | word >> (64 - bits); }
#endif
};

}  // namespace ros

#endif
