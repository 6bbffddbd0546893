// Defines how a node measures, writes, reads and names a message: generated ones by their fields, older ones by their
// virtual functions, and any other class by functions with the same names.
#ifndef ROS_WIRE_FORMAT_H_
#define ROS_WIRE_FORMAT_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/field_kind.h"
#include "ros/flash_names.h"
#include "ros/frame_writer.h"
#include "ros/inlining.h"
#include "ros/length_counter.h"
#include "ros/msg.h"
#include "ros/reader.h"
#include "ros/writer.h"

namespace ros {

template <class M, bool generated = IsMessage<M>::value>
struct WireFormat {
  // The class whose functions handle the message.
  typedef M Class;

  static FlashNames names() { return M::flashNames(); }
  static FlashNames names(const M*) { return names(); }

  // The serialized form, which is stored while its length and its bytes are needed.
  class Written {
   public:
    explicit Written(const M& message) : message_(message) {}
    ROS_FLATTEN size_t length() const {
      LengthCounter counter;
      M::_fields(counter, message_);
      return counter.length();
    }
    ROS_FLATTEN void write(FrameWriter& frame) const {
      Writer<FrameWriter> writer(frame);
      M::_fields(writer, message_);
      writer.finish();
    }

   private:
    const M& message_;
  };

  static void read(Reader& reader, M& message) { M::_fields(reader, message); }
};

// The class that handles a message with its own `serialize` and `deserialize`: Msg for all classes derived from it,
// otherwise the class itself.
template <bool is_msg, class M>
struct OwnForm {
  typedef Msg Class;
};
template <class M>
struct OwnForm<false, M> {
  typedef M Class;
};
template <class M>
struct IsMsg {
  static char test(const Msg*);
  static long test(...);
  static const bool value = sizeof(test(static_cast<M*>(nullptr))) == 1;
};

template <class M>
struct WireFormat<M, false> {
  typedef typename OwnForm<IsMsg<M>::value, M>::Class Class;

  struct Names {
    const char* type;
    const char* md5;

    size_t length() const { return 4 + strlen(type) + 4 + strlen(md5); }
    void write(FrameWriter& writer) const {
      writer.string(type);
      writer.string(md5);
    }
  };
  static Names names() {
    M message;
    return names(&message);
  }
  static Names names(Class* message) {
    const Names names = {message->getType(), message->getMD5()};
    return names;
  }

  class Written {
   public:
    explicit Written(const Class& message) : length_(static_cast<size_t>(message.serialize(bytes_))) {}
    size_t length() const { return length_; }
    void write(FrameWriter& frame) const { frame.put(bytes_, length_); }

   private:
    // `serialize` knows no bounds, so there must be room for the longest message. An AVR's stack has little.
#if defined(__AVR__)
    static const size_t LARGEST_MESSAGE_BYTES = 280;
#else
    static const size_t LARGEST_MESSAGE_BYTES = 4096;
#endif
    unsigned char bytes_[LARGEST_MESSAGE_BYTES];
    size_t length_;
  };

  static void read(Reader& reader, Class& message) { reader.unbounded(message); }
};

}  // namespace ros

#endif
