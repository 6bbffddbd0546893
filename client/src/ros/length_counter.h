#ifndef ROS_LENGTH_COUNTER_H_
#define ROS_LENGTH_COUNTER_H_

#include <stddef.h>
#include <string.h>

#include "ros/arrays.h"
#include "ros/field_kind.h"

namespace ros {

// An archive that measures a message. For types without strings and arrays, the length is a constant.
class LengthCounter {
 public:
  constexpr LengthCounter() : length_(0) {}
  size_t length() const { return length_; }

  template <class T>
  void value(const T&) {
    length_ += sizeof(T);
  }
  void value(const double&) { length_ += 8; }
  void string(const char* text) { length_ += 4 + (text ? strlen(text) : 0); }
  template <class M>
  void message(const M& part) {
    M::_fields(*this, part);
  }

  template <class T, size_t N>
  void fixed(const T (&array)[N]) {
    elements(array, N, typename FieldKind<T>::type());
  }
  template <class T>
  void sequence(T* array, array_length count) {
    length_ += 4;
    elements(array, presentLength(array, count), typename FieldKind<T>::type());
  }
  void sequence(const Float64Pointer& array, array_length count) { words(presentLength(array.address(), count)); }
  void sequence64(const unaligned_int64* array, array_length count) { words(presentLength(array, count)); }
  void sequence64(const unaligned_uint64* array, array_length count) { words(presentLength(array, count)); }

 private:
  void words(array_length count) { length_ += 4 + static_cast<size_t>(count) * 8; }

  template <class T>
  void elements(const T*, size_t count, BlockKind) {
    length_ += count * sizeof(T);
  }
  template <class T>
  void elements(const T*, size_t count, Float64Kind) {
    length_ += count * 8;
  }
  template <class T>
  void elements(const T* array, size_t count, StringKind) {
    for (size_t i = 0; i < count; ++i) string(array[i]);
  }
  template <class T>
  void elements(const T* array, size_t count, MessageKind) {
    for (size_t i = 0; i < count; ++i) message(array[i]);
  }

  size_t length_;
};

}  // namespace ros

#endif
