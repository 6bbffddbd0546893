// The base of message classes of an older generator, or written by hand: with virtual functions and without bounds.
//
// Sketches with such headers still compile and work. Generate the headers again if possible: the node can check these
// functions only after they have read a message, and needs a buffer on the stack for a message that they write.
#ifndef ROS_MSG_H_
#define ROS_MSG_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/float64.h"

namespace ros {

class Msg {
 public:
  virtual int serialize(unsigned char* outbuffer) const = 0;
  virtual int deserialize(unsigned char* inbuffer) = 0;
  virtual const char* getType() = 0;
  virtual const char* getMD5() = 0;

  static int serializeAvrFloat64(unsigned char* outbuffer, const float value) {
    widenFloat(&value, outbuffer);
    return 8;
  }
  static int deserializeAvrFloat64(const unsigned char* inbuffer, float* value) {
    *value = narrowFloat(inbuffer);
    return 8;
  }

  // Converts an integer to little-endian bytes, and back.
  template <class Bytes, class Value>
  static void varToArr(Bytes bytes, const Value value) {
    for (size_t i = 0; i < sizeof value; ++i) bytes[i] = static_cast<unsigned char>(value >> (8 * i));
  }
  template <class Value, class Bytes>
  static void arrToVar(Value& value, const Bytes bytes) {
    value = 0;
    for (size_t i = 0; i < sizeof value; ++i) value = static_cast<Value>(value | static_cast<Value>(bytes[i]) << (8 * i));
  }

 protected:
  // Not virtual: no code deletes a message through this class, and a virtual destructor would link the heap on an
  // AVR.
  ~Msg() {}
};

}  // namespace ros

#endif
