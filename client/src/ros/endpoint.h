#ifndef ROS_ENDPOINT_H_
#define ROS_ENDPOINT_H_

#include <stdint.h>

#include "ros/reader.h"

namespace ros {

class NodeHandleBase_;

// One publisher, subscriber or service of a sketch, in the linked list of its node handle.
//
// The code that depends on the message type is in one function, the driver. With a reader, it handles a message
// received on `id_`; without a reader, it announces the endpoint to the host. So each endpoint needs only one pointer
// in RAM, and no table of virtual functions.
class Endpoint {
 public:
  const char* topic_;
  // The topic id. A service receives on it and sends on the next id.
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
