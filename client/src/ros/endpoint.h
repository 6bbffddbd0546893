#ifndef ROS_ENDPOINT_H_
#define ROS_ENDPOINT_H_

#include <stdint.h>

#include "ros/reader.h"

namespace ros {

class NodeHandleBase_;

// One publisher, subscriber or service of a sketch, a link in its node handle's chain.
//
// What differs by message type is behind one function, the driver: with a reader it takes a message that came
// in on `id_`, without one it announces the endpoint to the host. One pointer is all that an AVR keeps of it in RAM.
class Endpoint {
 public:
  const char* topic_;
  // The id on which it receives, or for a publisher sends. A service sends on the next one.
  uint16_t id_;

 protected:
  typedef void (*Driver)(Endpoint& self, NodeHandleBase_& node, Reader* reader);

  constexpr Endpoint(const char* topic, Driver driver) : topic_(topic), id_(0), driver_(driver), next_(nullptr) {}

  Driver driver_;

 private:
  friend class NodeHandleBase_;
  Endpoint* next_;
};

// The name of a subscriber of any type in sketches for the established library.
typedef Endpoint Subscriber_;

}  // namespace ros

#endif
