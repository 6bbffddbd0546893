// What generated messages hold for arrays of variable length: a length and a pointer.
#ifndef ROS_ARRAYS_H_
#define ROS_ARRAYS_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/float64.h"

namespace ros {

#if defined(__AVR__)
typedef uint16_t array_length;  // no array can be longer than the address space
#else
typedef uint32_t array_length;
#endif

// The length of an array that a message sends. Sketches exist that set a length without elements.
inline array_length presentLength(const void* array, array_length length) { return array ? length : 0; }

// Elements of received arrays lie in the receive buffer, which aligns to four bytes only.
typedef int64_t unaligned_int64 __attribute__((aligned(4)));
typedef uint64_t unaligned_uint64 __attribute__((aligned(4)));

// One element of a float64[]: reads and writes through to wherever it is stored, float or double.
class Float64Reference {
 public:
  Float64Reference(void* address, bool narrow) : address_(address), narrow_(narrow) {}

  operator double() const {
    if (!narrow_) return loadDouble();
    float value;
    memcpy(&value, address_, sizeof value);
    return static_cast<double>(value);
  }
  Float64Reference& operator=(double value) {
    if (narrow_) {
      const float single = static_cast<float>(value);
      memcpy(address_, &single, sizeof single);
    } else {
      memcpy(address_, &value, sizeof value);
    }
    return *this;
  }
  Float64Reference(const Float64Reference&) = default;
  Float64Reference& operator=(const Float64Reference& other) { return *this = static_cast<double>(other); }
  Float64Reference& operator+=(double value) { return *this = *this + value; }
  Float64Reference& operator-=(double value) { return *this = *this - value; }
  Float64Reference& operator*=(double value) { return *this = *this * value; }

 private:
  double loadDouble() const {
    double value;
    memcpy(&value, address_, sizeof value);
    return value;
  }

  void* address_;
  bool narrow_;
};

// The elements of a float64[]. The established library has float* here on Arduino boards and double*
// on others; sketches of both kinds assign their arrays to it unchanged.
class Float64Pointer {
 public:
  constexpr Float64Pointer() : address_(nullptr), narrow_(false) {}
  constexpr Float64Pointer(decltype(nullptr)) : address_(nullptr), narrow_(false) {}
  constexpr Float64Pointer(double* address) : address_(address), narrow_(false) {}
  constexpr Float64Pointer(float* address) : address_(address), narrow_(sizeof(float) != sizeof(double)) {}

  Float64Reference operator[](size_t index) const {
    return Float64Reference(static_cast<uint8_t*>(address_) + index * elementBytes(), narrow_);
  }
  Float64Reference operator*() const { return (*this)[0]; }
  explicit operator bool() const { return address_ != nullptr; }
  void* address() const { return address_; }
  size_t elementBytes() const { return narrow_ ? sizeof(float) : sizeof(double); }

 private:
  void* address_;
  bool narrow_;
};

}  // namespace ros

#endif
