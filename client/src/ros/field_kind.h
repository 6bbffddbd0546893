// The form of an array's elements on the wire.
#ifndef ROS_FIELD_KIND_H_
#define ROS_FIELD_KIND_H_

#include <stdint.h>

namespace ros {

template <class M>
class Message;

// The wire format and all known boards are little endian: most values are sent as they are in memory.
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "ros_lib needs a little-endian processor"
#endif

struct BlockKind {};    // the bytes that it has in memory
struct Float64Kind {};  // a double of four bytes, eight on the wire
struct StringKind {};   // char pointer
struct MessageKind {};  // a message: its fields, one after the other

template <bool message>
struct ClassKind {
  typedef BlockKind type;
};
template <>
struct ClassKind<true> {
  typedef MessageKind type;
};

template <class T>
struct IsMessage {
  template <class M>
  static char test(const Message<M>*);
  static long test(...);
  static const bool value = sizeof(test(static_cast<T*>(nullptr))) == 1;
};

template <class T>
struct FieldKind {
  typedef typename ClassKind<IsMessage<T>::value>::type type;
};
template <>
struct FieldKind<char*> {
  typedef StringKind type;
};
template <>
struct FieldKind<const char*> {
  typedef StringKind type;
};
#if __SIZEOF_DOUBLE__ != 8
template <>
struct FieldKind<double> {
  typedef Float64Kind type;
};
#endif

}  // namespace ros

#endif
