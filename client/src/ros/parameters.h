// NodeHandleBase_::getParam: values from the host's parameter server.
#ifndef ROS_PARAMETERS_H_
#define ROS_PARAMETERS_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/node_handle_base.h"

namespace ros {

// One question for a parameter, and where its answer goes. Wire: RequestParam, whose response is the lists
// int32[] ints, float32[] floats, string[] strings, of which the host fills one, or none if there is no such parameter.
class ParameterRequest : public Endpoint {
 public:
  enum Kind { INTS, BOOLS, FLOATS, TEXTS, TEXT };

  // Asks for `name`; whether its values have been stored. `length` values at `values`; for TEXT one text of up to `length` bytes
  // with its NUL.
  static ROS_APART bool ask(NodeHandleBase_& node, const char* name, Kind kind, void* values, size_t length, int timeout_ms) {
    return ParameterRequest(name, kind, values, length).ask(node, static_cast<uint32_t>(timeout_ms));
  }

 private:
  ParameterRequest(const char* name, Kind kind, void* values, size_t length)
      : Endpoint(name, &drive), values_(values), length_(length), kind_(kind), state_(WAITING) {
    id_ = ID_PARAMETER_REQUEST;
  }

  bool ask(NodeHandleBase_& node, uint32_t timeout_ms) {
    const NodeHandleBase_::Visit visit(node, *this);
    node.begin(ID_PARAMETER_REQUEST, static_cast<uint16_t>(4 + strlen(topic_)));
    node.string(topic_);
    node.finish();
    const uint32_t began_ms = node.time();
    while (state_ == WAITING && node.time() - began_ms < timeout_ms) node.spinOnce();
    if (state_ == FOUND) return true;
    static const char unanswered[] ROS_FLASH = "Failed to get param: timeout expired";
    static const char misfit[] ROS_FLASH = "Failed to get param: length mismatch";
    const FlashText text = {state_ == WAITING ? unanswered : misfit};
    node.log(2, text);
    return false;
  }

  enum State { WAITING, FOUND, MISFIT };
  enum List { INT_LIST, FLOAT_LIST, TEXT_LIST };

  static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
    if (reader) static_cast<ParameterRequest&>(self).take(node, *reader);
  }

  // The list that the values come in.
  uint8_t list() const { return kind_ < FLOATS ? INT_LIST : kind_ == FLOATS ? FLOAT_LIST : TEXT_LIST; }

  void take(NodeHandleBase_& node, Reader& reader) {
    const uint8_t wanted = list();
    // Both lists of numbers have elements of four bytes: they are read alike.
    const uint8_t* found = nullptr;
    size_t found_count = 0;
    for (uint8_t list = INT_LIST; list <= FLOAT_LIST; ++list) {
      size_t count;
      const uint8_t* const numbers = reader.list(4, count);
      if (list == wanted) {
        found = numbers;
        found_count = count;
      }
    }
    uint32_t text_count = 0;
    reader.value(text_count);
    const bool fits = wanted == TEXT_LIST ? text_count == (kind_ == TEXT ? 1 : length_) : found_count == length_;
    for (size_t i = 0; i < text_count && reader.ok(); ++i) {
      const char* text;
      reader.string(text);
      if (fits) copyText(text, i);
    }
    if (!node.accept(reader)) return;
    state_ = fits ? FOUND : MISFIT;
    id_ = 0;  // the next answer is for another request
    if (!fits || wanted == TEXT_LIST) return;
    for (size_t i = 0; i < length_; ++i, found += 4) {
      int32_t value;
      memcpy(&value, found, sizeof value);
      if (kind_ == INTS) static_cast<int*>(values_)[i] = static_cast<int>(value);
      if (kind_ == BOOLS) static_cast<bool*>(values_)[i] = value != 0;
      if (kind_ == FLOATS) memcpy(static_cast<float*>(values_) + i, found, sizeof value);
    }
  }

  void copyText(const char* text, size_t index) {
    if (kind_ == TEXTS) {
      strcpy(static_cast<char**>(values_)[index], text);
    } else if (kind_ == TEXT) {
      strncpy(static_cast<char*>(values_), text, length_ - 1);
      static_cast<char*>(values_)[length_ - 1] = '\0';
    }
  }

  void* values_;
  size_t length_;
  uint8_t kind_;
  uint8_t state_;
};

inline bool NodeHandleBase_::getParam(const char* name, int* values, int length, int timeout_ms) {
  return ParameterRequest::ask(*this, name, ParameterRequest::INTS, values, length, timeout_ms);
}
inline bool NodeHandleBase_::getParam(const char* name, bool* values, int length, int timeout_ms) {
  return ParameterRequest::ask(*this, name, ParameterRequest::BOOLS, values, length, timeout_ms);
}
inline bool NodeHandleBase_::getParam(const char* name, float* values, int length, int timeout_ms) {
  return ParameterRequest::ask(*this, name, ParameterRequest::FLOATS, values, length, timeout_ms);
}
inline bool NodeHandleBase_::getParam(const char* name, char** values, int length, int timeout_ms) {
  return ParameterRequest::ask(*this, name, ParameterRequest::TEXTS, values, length, timeout_ms);
}
inline bool NodeHandleBase_::getParam(const char* name, char* text, size_t text_bytes, int timeout_ms) {
  return ParameterRequest::ask(*this, name, ParameterRequest::TEXT, text, text_bytes, timeout_ms);
}

}  // namespace ros

#endif
