#ifndef ROS_WRITER_H_
#define ROS_WRITER_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/arrays.h"
#include "ros/field_kind.h"

namespace ros {

// An archive that writes a message as ROS 1 serialization.
//
// Fields that are adjacent in memory and have the same bytes on the wire are written as one run. The compiler knows
// where the fields are. So a function that writes a message is ROS_FLATTEN: the search for runs disappears, and only
// one call per run is left. GCC 5 compares a field's address with another field's end at compile time, but not with a
// sum of an address and a length.
//
// Sink has `void put(const void* bytes, size_t count)`, `void widen(const void* floats, size_t bytes)` for the doubles
// of an AVR, `void count(size_t)` and `void string(const char*)`.
template <class Sink>
class Writer {
 public:
  explicit Writer(Sink& sink) : sink_(sink), run_(nullptr), end_(nullptr), run_bytes_(0), is_narrow_(false) {}

  template <class T>
  void value(const T& field) {
    extend(&field, sizeof(T), false);
  }
  void value(const double& field) { extend(&field, sizeof(double), sizeof(double) != 8); }
  void string(const char* text) {
    finish();
    sink_.string(text);
  }
  template <class M>
  void message(const M& part) {
    M::_fields(*this, part);
  }

  template <class T, size_t N>
  void fixed(const T (&array)[N]) {
    elements(array, N, typename FieldKind<T>::type());
  }
  template <class T>
  void sequence(T* array, array_length length) {
    length = presentLength(array, length);
    count(length);
    elements(array, length, typename FieldKind<T>::type());
    finish();
  }
  void sequence(const Float64Pointer& array, array_length length) {
    length = presentLength(array.address(), length);
    count(length);
    extend(array.address(), array.elementBytes() * length, array.elementBytes() != 8);
    finish();
  }
  void sequence64(const unaligned_int64* array, array_length length) { words(array, length); }
  void sequence64(const unaligned_uint64* array, array_length length) { words(array, length); }

  // Writes the last run; call it at the end.
  void finish() {
    if (run_bytes_ && is_narrow_) sink_.widen(run_, run_bytes_);
    if (run_bytes_ && !is_narrow_) sink_.put(run_, run_bytes_);
    run_bytes_ = 0;
  }

 private:
  void extend(const void* field, size_t bytes, bool is_narrow) {
    if (run_bytes_ && is_narrow == is_narrow_ && end_ == static_cast<const uint8_t*>(field)) {
      run_bytes_ += bytes;
      end_ = static_cast<const uint8_t*>(field) + bytes;
      return;
    }
    finish();
    run_ = static_cast<const uint8_t*>(field);
    end_ = static_cast<const uint8_t*>(field) + bytes;
    run_bytes_ = bytes;
    is_narrow_ = is_narrow;
  }
  void count(size_t length) {
    finish();
    sink_.count(length);
  }
  void words(const void* array, array_length length) {
    length = presentLength(array, length);
    count(length);
    sink_.put(array, static_cast<size_t>(length) * 8);
  }

  template <class T>
  void elements(const T* array, size_t length, BlockKind) {
    extend(array, length * sizeof(T), false);
  }
  template <class T>
  void elements(const T* array, size_t length, Float64Kind) {
    extend(array, length * sizeof(T), true);
  }
  template <class T>
  void elements(const T* array, size_t length, StringKind) {
    finish();
    for (size_t i = 0; i < length; ++i) sink_.string(array[i]);
  }
  template <class T>
  void elements(const T* array, size_t length, MessageKind) {
    finish();
    for (size_t i = 0; i < length; ++i) {
      Writer element(sink_);
      element.message(array[i]);
      element.finish();
    }
  }

  Sink& sink_;
  const uint8_t* run_;
  const uint8_t* end_;
  size_t run_bytes_;
  bool is_narrow_;
};

}  // namespace ros

#endif
