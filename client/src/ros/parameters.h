// NodeHandleBase_::getParam: values from the host's parameter server.
#ifndef ROS_PARAMETERS_H_
#define ROS_PARAMETERS_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/node_handle_base.h"

namespace ros {

// A request for a parameter, and the destination of its answer. Wire: the service RequestParam. Its response has the
// lists int32[] ints, float32[] floats and string[] strings. The host fills one of them, or none if it has no such
// parameter.
class ParameterRequest : public Endpoint {
 public:
  enum List { INT_LIST, FLOAT_LIST, TEXT_LIST };
  // Stores one element of the list: the four bytes of a number, or a string. There is one function for each kind of
  // value, and a program contains only those that it uses.
  typedef void (*Store)(void* values, size_t index, const uint8_t* element);

  // Requests `name`. If the parameter has `length` elements in this list, stores them and returns true.
  static ROS_APART bool ask(NodeHandleBase_& node, const char* name, List list, Store store, void* values, size_t length,
                            int timeout_ms) {
    return ParameterRequest(name, list, store, values, length).ask(node, static_cast<unsigned int>(timeout_ms));
  }

  static void storeInt(void* values, size_t index, const uint8_t* element) {
    int32_t value;
    memcpy(&value, element, sizeof value);
    static_cast<int*>(values)[index] = static_cast<int>(value);
  }
  static void storeBool(void* values, size_t index, const uint8_t* element) {
    static_cast<bool*>(values)[index] = (element[0] | element[1] | element[2] | element[3]) != 0;
  }
  static void storeFloat(void* values, size_t index, const uint8_t* element) {
    memcpy(static_cast<float*>(values) + index, element, 4);
  }
  static void storeText(void* values, size_t index, const uint8_t* element) {
    strcpy(static_cast<char**>(values)[index], reinterpret_cast<const char*>(element));
  }
  struct Buffer {
    char* text;
    size_t bytes;
  };
  static void storeInBuffer(void* values, size_t, const uint8_t* element) {
    const Buffer& buffer = *static_cast<const Buffer*>(values);
    strncpy(buffer.text, reinterpret_cast<const char*>(element), buffer.bytes - 1);
    buffer.text[buffer.bytes - 1] = '\0';
  }

 private:
  ParameterRequest(const char* name, List list, Store store, void* values, size_t length)
      : Endpoint(name, &drive), store_(store), values_(values), length_(length), list_(list), state_(AWAITING_VALUES) {
    id_ = ID_PARAMETER_REQUEST;
  }

  bool ask(NodeHandleBase_& node, unsigned int timeout_ms) {
    const NodeHandleBase_::Temporary temporary(node, *this);
    node.begin(ID_PARAMETER_REQUEST, static_cast<uint16_t>(4 + strlen(topic_)));
    node.string(topic_);
    node.finish();
    const unsigned int began_ms = static_cast<unsigned int>(node.time());
    while (state_ == AWAITING_VALUES && static_cast<unsigned int>(node.time()) - began_ms < timeout_ms) node.spinOnce();
    if (state_ == GOT_VALUES) return true;
    static const char unanswered[] ROS_FLASH = "Failed to get param: timeout expired";
    static const char misfit[] ROS_FLASH = "Failed to get param: length mismatch";
    const FlashText text = {state_ == AWAITING_VALUES ? unanswered : misfit};
    node.log(2, text);
    return false;
  }

  enum State { AWAITING_VALUES, GOT_VALUES, GOT_OTHER_VALUES };

  static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
    if (reader) static_cast<ParameterRequest&>(self).receive(node, *reader);
  }

  void receive(NodeHandleBase_& node, Reader& reader) {
    const uint8_t* numbers = nullptr;
    bool fits = false;
    for (uint8_t list = INT_LIST; list <= TEXT_LIST; ++list) {
      // Each element of a list takes at least four bytes.
      size_t count = reader.listLength(4);
      if (list == list_) fits = count == length_;
      if (list != TEXT_LIST) {
        const uint8_t* const first = reader.skip(count * 4);
        if (list == list_) numbers = first;
        continue;
      }
      for (size_t i = 0; i < count && reader.ok(); ++i) {
        const char* text;
        reader.string(text);
        if (list_ == TEXT_LIST && fits) store_(values_, i, reinterpret_cast<const uint8_t*>(text));
      }
    }
    if (!node.accept(reader)) return;
    state_ = fits ? GOT_VALUES : GOT_OTHER_VALUES;
    id_ = 0;  // the next answer is for another request
    if (!fits || !numbers) return;
    for (size_t i = 0; i < length_; ++i, numbers += 4) store_(values_, i, numbers);
  }

  Store store_;
  void* values_;
  size_t length_;
  uint8_t list_;
  uint8_t state_;
};

inline bool NodeHandleBase_::getParam(const char* name, int* values, int length, int timeout_ms) {
  return ParameterRequest::ask(*this, name, ParameterRequest::INT_LIST, &ParameterRequest::storeInt, values, length, timeout_ms);
}
inline bool NodeHandleBase_::getParam(const char* name, bool* values, int length, int timeout_ms) {
  return ParameterRequest::ask(*this, name, ParameterRequest::INT_LIST, &ParameterRequest::storeBool, values, length, timeout_ms);
}
inline bool NodeHandleBase_::getParam(const char* name, float* values, int length, int timeout_ms) {
  return ParameterRequest::ask(*this, name, ParameterRequest::FLOAT_LIST, &ParameterRequest::storeFloat, values, length, timeout_ms);
}
inline bool NodeHandleBase_::getParam(const char* name, char** values, int length, int timeout_ms) {
  return ParameterRequest::ask(*this, name, ParameterRequest::TEXT_LIST, &ParameterRequest::storeText, values, length, timeout_ms);
}
inline bool NodeHandleBase_::getParam(const char* name, char* text, size_t text_bytes, int timeout_ms) {
  ParameterRequest::Buffer buffer = {text, text_bytes};
  return ParameterRequest::ask(*this, name, ParameterRequest::TEXT_LIST, &ParameterRequest::storeInBuffer, &buffer, 1, timeout_ms);
}

}  // namespace ros

#endif
