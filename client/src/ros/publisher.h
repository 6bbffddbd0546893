#ifndef ROS_PUBLISHER_H_
#define ROS_PUBLISHER_H_

#include <stdint.h>

#include "ros/node_handle_base.h"

namespace ros {

// Sends messages of one type to a topic. The message in the constructor defines the type.
class Publisher : public Endpoint {
 public:
  template <class M>
  constexpr Publisher(const char* topic, M* message, int = ID_PUBLISHER)
      : Endpoint(topic, &drive<typename WireFormat<M>::Class>),
        msg_(static_cast<typename WireFormat<M>::Class*>(message)),
        nh_(nullptr) {}

  // Returns the number of bytes sent; 0 if the topic is not advertised or no host is connected; -1 if the message has
  // a different type than the topic, is too long for a frame, or was not accepted by the line.
  template <class M>
  int publish(const M* message) {
    if (!nh_) return 0;
    typedef typename WireFormat<M>::Class Class;
    if (driver_ != &drive<Class>) return -1;
    return nh_->send<Class>(id_, *message);
  }
  int getEndpointType() const { return ID_PUBLISHER; }

  void* msg_;
  NodeHandleBase_* nh_;

 private:
  template <class M>
  static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
    if (reader) return;
    node.announce(self, ID_PUBLISHER, WireFormat<M>::names(static_cast<M*>(static_cast<Publisher&>(self).msg_)));
  }
};

inline bool NodeHandleBase_::advertise(Publisher& publisher) {
  publisher.nh_ = this;
  return add(publisher, 1);
}

}  // namespace ros

#endif
