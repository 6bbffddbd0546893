#include <math.h>
#include <ros/arrays.h>
#include <ros/float64.h>

#include "expect.h"
#include "bytes.h"

// The host processor's result for the same bits.
static uint64_t widened(uint32_t bits) {
  if ((bits & 0x7f800000) == 0x7f800000) {
    return static_cast<uint64_t>(bits & 0x80000000) << 32 | 0x7ff0000000000000ULL | static_cast<uint64_t>(bits & 0x7fffff) << 29;
  }
  float single;
  memcpy(&single, &bits, 4);
  const double wide = static_cast<double>(single);
  uint64_t result;
  memcpy(&result, &wide, 8);
  return result;
}

static uint64_t widen(uint32_t bits) {
  uint8_t bytes[8];
  memset(bytes, 0xaa, 8);
  ros::widenFloat(&bits, bytes);
  uint64_t result;
  memcpy(&result, bytes, 8);
  return result;
}

static uint32_t narrow(uint64_t bits) {
  uint8_t bytes[8];
  memcpy(bytes, &bits, 8);
  const float single = ros::narrowFloat(bytes);
  uint32_t result;
  memcpy(&result, &single, 4);
  return result;
}

static void expectNarrow(uint64_t bits) {
  double wide;
  memcpy(&wide, &bits, 8);
  const uint32_t got = narrow(bits);
  if (isnan(wide)) {
    EXPECT((got & 0x7f800000) == 0x7f800000 && (got & 0x7fffff) != 0);
    EXPECT_EQUAL(got >> 31, static_cast<uint32_t>(bits >> 63));
    return;
  }
  // Rounds to nearest, ties to even.
  volatile float single = static_cast<float>(fabs(wide) > 3.4028235677973366e38 ? copysign(INFINITY, wide) : wide);
  const float value = single;
  uint32_t wanted;
  memcpy(&wanted, &value, 4);
  EXPECT_EQUAL(got, wanted);
}

static uint64_t state = 88172645463325252ULL;
static uint64_t random64() {
  state ^= state << 13;
  state ^= state >> 7;
  return state ^= state << 17;
}

TEST(float64, every_exponent_both_ways) {
  for (uint32_t sign = 0; sign < 2; ++sign) {
    for (uint32_t exponent = 0; exponent < 256; ++exponent) {
      const uint32_t mantissas[] = {0, 1, 2, 3, 0x400000, 0x3fffff, 0x7ffffe, 0x7fffff, 0x155555, 0x2aaaaa};
      for (uint32_t mantissa : mantissas) {
        const uint32_t bits = sign << 31 | exponent << 23 | mantissa;
        EXPECT_EQUAL(widen(bits), widened(bits));
        EXPECT_EQUAL(narrow(widen(bits)), bits);
      }
    }
  }
}

TEST(float64, two_million_floats_both_ways) {
  for (uint32_t i = 0; i < 2000000; ++i) {
    const uint32_t bits = i * 2147u + (i << 20);
    EXPECT_EQUAL(widen(bits), widened(bits));
    EXPECT_EQUAL(narrow(widen(bits)), bits);
  }
}

TEST(float64, edges_of_rounding) {
  for (uint64_t sign = 0; sign < 2; ++sign) {
    for (uint64_t exponent = 0; exponent < 2048; ++exponent) {
      const uint64_t mantissas[] = {0, 1, 0x8000000, 0x10000000, 0x10000001, 0xfffffff, 0x1fffffff, 0x20000000, 0x30000000,
                                    0x30000001, 0x2fffffff, 0xfffffffffffffULL, 0xfffffefffffffULL, 0xffffff0000000ULL,
                                    0xfffffe0000000ULL, 0x8000000000000ULL, 0x8000010000000ULL, 0x8000000000001ULL};
      for (uint64_t mantissa : mantissas) expectNarrow(sign << 63 | exponent << 52 | mantissa);
    }
  }
}

TEST(float64, random_doubles) {
  for (int i = 0; i < 2000000; ++i) {
    uint64_t bits = random64();
    // Half of them are in the range of a float, and some are exact in a float.
    if (i % 2) bits = (bits & 0x800fffffffffffffULL) | (865 + random64() % 300) << 52;
    if (i % 5 == 0) bits &= ~0xfffffffULL;
    expectNarrow(bits);
  }
}

// Arduino's macro `constrain`: its type is the common type of its operands.
#define CONSTRAIN(value, low, high) ((value) < (low) ? (low) : ((value) > (high) ? (high) : (value)))

TEST(float64, a_received_element_is_a_double) {
  double wide[] = {0.5, -3};
  float narrow[] = {0.5f, -3};
  const ros::Float64Pointer arrays[] = {wide, narrow};
  for (const ros::Float64Pointer& array : arrays) {
    EXPECT_EQUAL(CONSTRAIN(array[0], -1, 1), 0.5);
    EXPECT_EQUAL(CONSTRAIN(array[1], -1, 1), -1.0);
  }
}
