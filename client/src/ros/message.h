// The headers of every generated message.
//
// A generated class lists its fields once, in `_fields` (a name that no field can have). LengthCounter, Writer
// and Reader visit that list to measure a message, to write it and to read it. There are no virtual functions, because
// an AVR would keep each class's table in RAM.
#ifndef ROS_MESSAGE_H_
#define ROS_MESSAGE_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/arrays.h"
#include "ros/buffer_writer.h"
#include "ros/duration.h"
#include "ros/flash.h"
#include "ros/flash_names.h"
#include "ros/length_counter.h"
#include "ros/reader.h"
#include "ros/time.h"
#include "ros/writer.h"

// The type and md5sum of a message: getType and getMD5 for sketches, and the same texts in flash for announcements.
// A space is 32: " \0\0\0" is the length of the md5sum on the wire.
#define ROS_MESSAGE_TYPE(type, md5)                                    \
  static const char* getType() { return type; }                        \
  static constexpr const char* getMD5() { return md5; }                \
  static ros::FlashNames flashNames() {                                \
    static const struct {                                              \
      uint8_t type_length;                                             \
      char both[sizeof type " \0\0\0" md5];                            \
    } names ROS_FLASH = {sizeof type - 1, type " \0\0\0" md5};         \
    return ros::FlashNames(&names.type_length);                        \
  }

namespace ros {

// The base of the generated message M. It works without a node handle, with any buffer (a raw UDP packet, a file).
template <class M>
class Message {
 public:
  // The number of bytes that serialize writes.
  size_t serializedLength() const {
    LengthCounter counter;
    M::_fields(counter, self());
    return counter.length();
  }

  // Writes the message and returns its length. The buffer must hold serializedLength() bytes.
  int serialize(unsigned char* buffer) const {
    BufferWriter sink(buffer);
    Writer<BufferWriter> writer(sink);
    M::_fields(writer, self());
    writer.finish();
    return static_cast<int>(sink.length());
  }

  // The same, but returns -1 and writes nothing if the message does not fit in `capacity` bytes.
  int serialize(unsigned char* buffer, size_t capacity) const {
    return serializedLength() <= capacity ? serialize(buffer) : -1;
  }

  // Reads a message of exactly `length` bytes. Returns `length`, or -1 if the bytes are not a message of this type.
  // Moves bytes in `buffer`: strings and arrays then point into it. Arrays of strings and of messages need more memory,
  // which is the end of the buffer: [length, capacity).
  int deserialize(unsigned char* buffer, size_t length, size_t capacity) {
    Reader reader(buffer, length, buffer + length, buffer + capacity);
    M::_fields(reader, self());
    return reader.complete() ? static_cast<int>(length) : -1;
  }
  int deserialize(unsigned char* buffer, size_t length) { return deserialize(buffer, length, length); }

  // Reads a message from bytes that are known to be valid. Returns their number, or -1. Prefer the function above: this
  // one does not know where the buffer ends. It stores arrays of strings and of messages on the heap; on an AVR it
  // refuses them.
  int deserialize(unsigned char* buffer) {
    Reader reader(buffer);
    M::_fields(reader, self());
    return reader.ok() ? static_cast<int>(reader.consumed(buffer)) : -1;
  }

 protected:
  constexpr Message() {}

 private:
  const M& self() const { return static_cast<const M&>(*this); }
  M& self() { return static_cast<M&>(*this); }
};

}  // namespace ros

#endif
