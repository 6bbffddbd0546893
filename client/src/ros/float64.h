// Converts between the eight bytes of a float64 and the four bytes of an AVR's double, exactly as IEEE 754 requires.
//
//   float   s eeeeeeee    mmmmmmm mmmmmmmm mmmmmmmm                  bias 127
//   float64 s eeeeeeeeeee mmmm mmmmmmmm mmmmmmmm mmm.. (29 bits more)  bias 1023
//
// Widening is always exact. Narrowing rounds to nearest, ties to even, including to subnormals and to infinity; a NaN
// stays a NaN with its sign. The code works byte by byte, because an AVR has no barrel shifter.
#ifndef ROS_FLOAT64_H_
#define ROS_FLOAT64_H_

#include <stdint.h>
#include <string.h>

namespace ros {

// Widens the float at `from` to eight bytes at `bytes`, and returns their sum. A shift by five is a multiplication,
// which an AVR does in two cycles.
inline uint8_t widenFloat(const void* from, uint8_t* bytes) {
  const uint8_t* f = static_cast<const uint8_t*>(from);
  uint8_t f0 = f[0], f1 = f[1], f2 = f[2];
  const uint8_t sign = f[3] & 0x80, f3 = f[3] & 0x7f;
  uint16_t top = 0;
  if (f0 | f1 | f2 | f3) {
    // The difference of the exponents' biases: 896; twice that for infinities and NaNs.
    top = 0x3800;
    if (f3 == 0x7f && f2 & 0x80) top = 0x7000;
    if (f3 == 0) {
      for (; !(f2 & 0x80); top = static_cast<uint16_t>(top - 0x10)) {
        f2 = static_cast<uint8_t>(f2 << 1 | f1 >> 7);
        f1 = static_cast<uint8_t>(f1 << 1 | f0 >> 7);
        f0 = static_cast<uint8_t>(f0 << 1);
      }
    }
  }
  const uint16_t p0 = static_cast<uint16_t>(f0 * 32), p1 = static_cast<uint16_t>(f1 * 32), p2 = static_cast<uint16_t>(f2 * 32);
  top = static_cast<uint16_t>(top + f3 * 32 + (p2 >> 8));
  const uint8_t high = static_cast<uint8_t>(top >> 8 | sign), next = static_cast<uint8_t>(top);
  const uint8_t b5 = static_cast<uint8_t>(p2 | p1 >> 8), b4 = static_cast<uint8_t>(p1 | p0 >> 8), b3 = static_cast<uint8_t>(p0);
  bytes[0] = bytes[1] = bytes[2] = 0;
  bytes[3] = b3;
  bytes[4] = b4;
  bytes[5] = b5;
  bytes[6] = next;
  bytes[7] = high;
  return static_cast<uint8_t>(b3 + b4 + b5 + next + high);
}

inline float narrowFloat(const uint8_t* bytes) {
  const uint16_t exponent = static_cast<uint16_t>((bytes[7] & 0x7f) << 4 | bytes[6] >> 4);
  uint32_t bits = 0;
  uint8_t f[4];
  f[0] = static_cast<uint8_t>(bytes[3] >> 5 | bytes[4] << 3);
  f[1] = static_cast<uint8_t>(bytes[4] >> 5 | bytes[5] << 3);
  f[2] = static_cast<uint8_t>((bytes[5] >> 5 | bytes[6] << 3) & 0x7f);
  f[3] = 0;
  memcpy(&bits, f, 4);
  // The remaining bits: bit 7 is half a unit in the last place, the others show whether there is more.
  uint8_t rest = static_cast<uint8_t>(bytes[3] << 3);
  if (bytes[2] | bytes[1] | bytes[0]) rest |= 1;
  if (exponent == 2047) {
    if (bits == 0 && rest) bits = 1;
    bits |= 0x7f800000UL;
  } else if (exponent > 1150) {
    bits = 0x7f800000UL;
  } else if (exponent < 873) {
    bits = 0;
  } else {
    if (exponent > 896) {
      bits += static_cast<uint32_t>(exponent - 896) << 23;
    } else {
      bits |= 0x800000UL;
      for (uint16_t shift = exponent; shift <= 896; ++shift) {
        rest = static_cast<uint8_t>((bits & 1) << 7 | rest >> 1 | (rest & 1));
        bits >>= 1;
      }
    }
    // A carry out of the mantissa gives the right next exponent, up to infinity.
    if (rest > 0x80 || (rest == 0x80 && (bits & 1))) ++bits;
  }
  if (bytes[7] & 0x80) bits |= 0x80000000UL;
  float value;
  memcpy(&value, &bits, 4);
  return value;
}

// Stores `value` as the eight little-endian bytes of a float64. On an AVR, `value` is a double of four bytes.
inline void storeFloat64(uint8_t* bytes, double value) {
  if (sizeof(double) == 8) {
    memcpy(bytes, &value, sizeof value);
  } else {
    const float single = static_cast<float>(value);
    widenFloat(&single, bytes);
  }
}

inline double loadFloat64(const uint8_t* bytes) {
  if (sizeof(double) != 8) return static_cast<double>(narrowFloat(bytes));
  double value;
  memcpy(&value, bytes, sizeof value);
  return value;
}

}  // namespace ros

#endif
