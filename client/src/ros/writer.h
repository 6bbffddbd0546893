#ifndef ROS_WRITER_H_
#define ROS_WRITER_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "arrays.h"
#include "field_kind.h"
#include "float64.h"

namespace ros {

// Archive that writes a message as ROS 1 serialization: what all writers share. Sink has
// `void put(const void* bytes, size_t count)`.
template <class Sink>
class Writer {
 public:
  template <class T>
  void value(const T& field) {
    sink().put(&field, sizeof(T));
  }
  void value(const double& field) {
    uint8_t bytes[8];
    storeFloat64(bytes, field);
    sink().put(bytes, 8);
  }
  void string(const char* text) {
    const size_t length = text ? strlen(text) : 0;
    count(length);
    sink().put(text, length);
  }
  template <class M>
  void message(const M& part) {
    M::_fields(sink(), part);
  }

  template <class T, size_t N>
  void fixed(const T (&array)[N]) {
    elements(array, N, typename FieldKind<T>::type());
  }
  template <class T>
  void sequence(T* array, array_length length) {
    count(length);
    elements(array, length, typename FieldKind<T>::type());
  }
  void sequence(const Float64Pointer& array, array_length length) {
    count(length);
    for (size_t i = 0; i < length; ++i) value(static_cast<double>(array[i]));
  }
  void sequence64(const unaligned_int64* array, array_length length) { words(array, length); }
  void sequence64(const unaligned_uint64* array, array_length length) { words(array, length); }

  // The four bytes before a string or an array.
  void count(size_t length) {
    const uint32_t prefix = static_cast<uint32_t>(length);
    sink().put(&prefix, 4);
  }

 protected:
  constexpr Writer() {}

 private:
  void words(const void* array, array_length length) {
    count(length);
    sink().put(array, static_cast<size_t>(length) * 8);
  }

  template <class T>
  void elements(const T* array, size_t length, BlockKind) {
    sink().put(array, length * sizeof(T));
  }
  template <class T>
  void elements(const T* array, size_t length, Float64Kind) {
    for (size_t i = 0; i < length; ++i) value(array[i]);
  }
  template <class T>
  void elements(const T* array, size_t length, StringKind) {
    for (size_t i = 0; i < length; ++i) string(array[i]);
  }
  template <class T>
  void elements(const T* array, size_t length, MessageKind) {
    for (size_t i = 0; i < length; ++i) message(array[i]);
  }

  Sink& sink() { return static_cast<Sink&>(*this); }
};

}  // namespace ros

#endif
