// An archive that reads a message from its bytes, and never beyond them.
//
// Data stays in the buffer if possible. A string moves down by one byte, over its length prefix, to make room for its
// NUL. An array of numbers stays, or moves down by up to three bytes if the processor needs aligned words. Arrays of
// strings and of messages need additional memory, the arena.
#ifndef ROS_READER_H_
#define ROS_READER_H_

#include <stddef.h>
#include <stdint.h>
#if !defined(__AVR__)
#include <stdlib.h>
#endif
#include <string.h>

#include "ros/arrays.h"
#include "ros/field_kind.h"
#include "ros/float64.h"
#include "ros/inlining.h"

namespace ros {

class Reader {
 public:
  Reader() = default;
  // Reads `length` bytes; the arena [arena, arena_end) is used from its end downwards.
  Reader(uint8_t* buffer, size_t length, uint8_t* arena, uint8_t* arena_end) { open(buffer, length, arena, arena_end); }
  // Trusts the bytes, and uses the heap instead of an arena (on an AVR it refuses such arrays).
  explicit Reader(uint8_t* buffer)
      : next_(buffer), remaining_(SIZE_MAX / 2), arena_(nullptr), arena_end_(nullptr), ok_(true), heap_(true) {}

  // Starts to read these bytes; the arguments are those of the constructor.
  void open(uint8_t* buffer, size_t length, uint8_t* arena, uint8_t* arena_end) {
    next_ = buffer;
    remaining_ = length;
    arena_ = arena;
    arena_end_ = arena_end;
    ok_ = true;
    heap_ = false;
  }

  bool ok() const { return ok_; }
  // Whether the bytes were exactly one message.
  bool complete() const { return ok_ && remaining_ == 0; }
  size_t consumed(const uint8_t* buffer) const { return static_cast<size_t>(next_ - buffer); }
  uint8_t* arenaEnd() const { return arena_end_; }

  template <class T>
  void value(T& field) {
    copy(&field, sizeof(T));
  }
  void value(bool& field) {
    uint8_t byte = 0;
    copy(&byte, 1);
    field = byte != 0;
  }
  void value(double& field) {
    uint8_t bytes[8] = {0, 0, 0, 0, 0, 0, 0, 0};
    copy(bytes, 8);
    field = loadFloat64(bytes);
  }
  void string(const char*& text) {
    const size_t length = prefix();
    if (!ok_) {
      text = "";
      return;
    }
    char* start = reinterpret_cast<char*>(next_) - 1;
    memmove(start, next_, length);
    start[length] = '\0';
    text = start;
    advance(length);
  }
  template <class M>
  void message(M& part) {
    M::_fields(*this, part);
  }

  // Reads a message with the message's own function, which knows no bounds: it can be checked only afterwards.
  template <class M>
  void unbounded(M& message) {
    const int consumed = message.deserialize(next_);
    if (consumed < 0 || static_cast<size_t>(consumed) > remaining_) {
      fail();
    } else {
      advance(static_cast<size_t>(consumed));
    }
  }

  template <class T, size_t N>
  void fixed(T (&array)[N]) {
    elements(array, N, typename FieldKind<T>::type());
  }
  template <class T>
  void sequence(T*& array, array_length& count) {
    const array_length old_length = count;
    const size_t length = sequenceLength(sizeof(T), typename FieldKind<T>::type());
    count = static_cast<array_length>(length);
    if (length == 0) {
      if (!heap_) array = nullptr;
      return;
    }
    place(array, length, old_length, typename FieldKind<T>::type());
    if (!ok_) count = 0;
  }
  void sequence(Float64Pointer& array, array_length& count) {
    const size_t length = sequenceLength(8, BlockKind());
    count = static_cast<array_length>(length);
    double* start = reinterpret_cast<double*>(next_);
    if (sizeof(double) != 8) {
      // Four bytes replace eight, so the written part never reaches the part that is not yet read.
      for (size_t i = 0; i < length; ++i) {
        const double element = loadFloat64(next_ + i * 8);
        memcpy(next_ + i * sizeof element, &element, sizeof element);
      }
    }
    array = start;
    advance(length * 8);
  }
  // Reads the prefix of an array and returns the number of its elements; 0, with ok() false, if too few bytes are left
  // for them. Each element takes at least `element_bytes`.
  size_t listLength(size_t element_bytes) {
    const size_t length = prefix();
    if (length > remaining_ / element_bytes) {
      fail();
      return 0;
    }
    return length;
  }
  // Skips bytes, which must be available, and returns their address, which may not be aligned.
  const uint8_t* skip(size_t bytes) {
    const uint8_t* start = next_;
    advance(bytes);
    return start;
  }
  void sequence64(unaligned_int64*& array, array_length& count) {
    array = reinterpret_cast<unaligned_int64*>(words(count));
  }
  void sequence64(unaligned_uint64*& array, array_length& count) {
    array = reinterpret_cast<unaligned_uint64*>(words(count));
  }

 private:
  void fail() {
    ok_ = false;
    remaining_ = 0;
  }
  void advance(size_t count) {
    next_ += count;
    remaining_ -= count;
  }
  void copy(void* field, size_t count) {
    if (count > remaining_) {
      fail();
      return;
    }
    memcpy(field, next_, count);
    advance(count);
  }

  // Reads the length before a string or an array; returns 0, with ok() false, if it is larger than the number of bytes
  // left.
  ROS_APART size_t prefix() {
    uint32_t length = 0;
    value(length);
    if (length > remaining_) {
      fail();
      return 0;
    }
    return static_cast<size_t>(length);
  }
  size_t sequenceLength(size_t size, BlockKind) { return listLength(size); }
  size_t sequenceLength(size_t, Float64Kind) { return listLength(8); }
  size_t sequenceLength(size_t, StringKind) { return listLength(4); }
  // A message may have no bytes on the wire; `allocate` limits the number of messages.
  size_t sequenceLength(size_t, MessageKind) {
    uint32_t length = 0;
    value(length);
    if (length > remaining_ && length > static_cast<size_t>(arena_end_ - arena_)) fail();
    return ok_ ? static_cast<size_t>(length) : 0;
  }

  // Returns the address of an array's elements of `size` bytes, which stay or move down over the end of their prefix.
  uint8_t* settle(size_t length, size_t size) {
    uint8_t* start = next_;
#if !defined(__AVR__)
    const size_t shift = reinterpret_cast<uintptr_t>(start) % (size < 4 ? size : 4);
    start -= shift;
    if (shift) memmove(start, next_, length * size);
#endif
    advance(length * size);
    return start;
  }
  uint8_t* words(array_length& count) {
    const size_t length = listLength(8);
    count = static_cast<array_length>(length);
    return settle(length, 8);
  }
  template <class T>
  void place(T*& array, size_t length, array_length, BlockKind) {
    array = reinterpret_cast<T*>(settle(length, sizeof(T)));
    normalize(array, length);
  }
  template <class T>
  void place(T*& array, size_t length, array_length old_length, StringKind kind) {
    array = allocate(array, length, old_length);
    if (!array) return;
    elements(array, length, kind);
  }
  template <class T>
  void place(T*& array, size_t length, array_length old_length, MessageKind) {
    array = allocate(array, length, old_length);
    if (!array) return;
    for (size_t i = heap_ ? old_length : 0; i < length; ++i) array[i] = T();
    for (size_t i = 0; i < length && ok_; ++i) message(array[i]);
  }

  template <class T>
  T* allocate(T* array, size_t length, array_length old_length) {
#if !defined(__AVR__)
    if (heap_) {
      if (length <= old_length) return array;
      T* grown = static_cast<T*>(realloc(static_cast<void*>(array), length * sizeof(T)));
      if (!grown) fail();
      return grown;
    }
#else
    (void)array;
    (void)old_length;
#endif
    uint8_t* end = arena_end_ - reinterpret_cast<uintptr_t>(arena_end_) % alignof(T);
    if (end < arena_ || length > static_cast<size_t>(end - arena_) / sizeof(T)) {
      fail();
      return nullptr;
    }
    arena_end_ = end - length * sizeof(T);
    return reinterpret_cast<T*>(arena_end_);
  }

  template <class T>
  void elements(T* array, size_t length, BlockKind) {
    copy(array, length * sizeof(T));
  }
  void elements(bool* array, size_t length, BlockKind) {
    for (size_t i = 0; i < length; ++i) value(array[i]);
  }
  template <class T>
  void elements(T* array, size_t length, Float64Kind) {
    for (size_t i = 0; i < length; ++i) value(array[i]);
  }
  template <class T>
  void elements(T* array, size_t length, StringKind) {
    for (size_t i = 0; i < length; ++i) {
      const char* text;
      string(text);
      array[i] = const_cast<char*>(text);
    }
  }
  template <class T>
  void elements(T* array, size_t length, MessageKind) {
    for (size_t i = 0; i < length; ++i) message(array[i]);
  }

  // Corrects the bytes of an array of bool in place: a bool must be 0 or 1.
  template <class T>
  void normalize(T*, size_t) {}
  void normalize(bool* array, size_t length) {
    uint8_t* bytes = reinterpret_cast<uint8_t*>(array);
    for (size_t i = 0; i < length; ++i) bytes[i] = bytes[i] != 0;
  }

  uint8_t* next_;
  size_t remaining_;
  uint8_t* arena_;
  uint8_t* arena_end_;
  bool ok_;
  bool heap_;
};

}  // namespace ros

#endif
