// Arrays of variable length in generated messages: a length and a pointer.
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

// The length of an array in a message to send. Some sketches set a length without elements.
inline array_length presentLength(const void* array, array_length length) { return array ? length : 0; }

// Elements of received arrays stay in the receive buffer, which is aligned only to four bytes.
typedef int64_t unaligned_int64 __attribute__((aligned(4)));
typedef uint64_t unaligned_uint64 __attribute__((aligned(4)));

// The elements of a float64[]. The established library uses float* on Arduino boards and double* on others; sketches
// of both kinds can assign their arrays unchanged.
#if __SIZEOF_DOUBLE__ == 4

// A double is a float here: this is the float* of the established library.
class Float64Pointer {
  // A sketch may have an array of double, which is another type for the compiler.
  typedef float Element __attribute__((__may_alias__));

 public:
  constexpr Float64Pointer() : address_(nullptr) {}
  constexpr Float64Pointer(float* address) : address_(address) {}
  // A template, so that NULL and 0 have one constructor to choose.
  template <class Double, int = sizeof(static_cast<double*>(static_cast<Double*>(nullptr)))>
  Float64Pointer(Double* address) : address_(reinterpret_cast<Element*>(address)) {}

  operator Element*() const { return address_; }
  void* address() const { return address_; }
  size_t elementBytes() const { return sizeof(float); }

 private:
  Element* address_;
};

#else

// One element of a float64[]: reads and writes its memory, which is float or double.
class Float64Reference {
 public:
  Float64Reference(void* address, bool narrow) : address_(address), narrow_(narrow) {}
  // Only for integers (`~` needs one). Without this constructor, `constrain(array[0], -1, 1)` would have the type of
  // the limits, and lose the fraction.
  template <class Integer, int = sizeof(~Integer())>
  Float64Reference(Integer) = delete;

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
  Float64Reference& operator/=(double value) { return *this = *this / value; }
  Float64Reference& operator++() { return *this += 1; }
  Float64Reference& operator--() { return *this -= 1; }

 private:
  double loadDouble() const {
    double value;
    memcpy(&value, address_, sizeof value);
    return value;
  }

  void* address_;
  bool narrow_;
};

class Float64Pointer {
 public:
  constexpr Float64Pointer() : address_(nullptr), narrow_(false) {}
  constexpr Float64Pointer(double* address) : address_(address), narrow_(false) {}
  // A template, so that NULL and 0 have one constructor to choose.
  template <class Float, int = sizeof(static_cast<float*>(static_cast<Float*>(nullptr)))>
  constexpr Float64Pointer(Float* address) : address_(address), narrow_(true) {}

  Float64Reference operator[](size_t index) { return Float64Reference(at(index), narrow_); }
  // Returns a number, not a reference, so that macros such as `constrain` work with elements of a received message.
  double operator[](size_t index) const { return Float64Reference(at(index), narrow_); }
  Float64Reference operator*() { return (*this)[0]; }
  double operator*() const { return (*this)[0]; }
  explicit operator bool() const { return address_ != nullptr; }
  void* address() const { return address_; }
  size_t elementBytes() const { return narrow_ ? sizeof(float) : sizeof(double); }

 private:
  void* at(size_t index) const { return static_cast<uint8_t*>(address_) + index * elementBytes(); }

  void* address_;
  bool narrow_;
};

#endif

}  // namespace ros

#endif
