#ifndef ROS_SUBSCRIBER_H_
#define ROS_SUBSCRIBER_H_

#include "ros/callback.h"
#include "ros/node_handle_base.h"

namespace ros {

// Runs a callback, a function or a member function of an object, for each message of a topic. Strings and arrays of the
// message point into the receive buffer: copy data that you need after the callback.
template <class M, class Object = void>
class Subscriber : public Endpoint {
 public:
  typedef typename Callback<Object, const M&>::Function CallbackT;

  constexpr Subscriber(const char* topic, CallbackT callback, int = ID_SUBSCRIBER)
      : Endpoint(topic, &drive), callback_(callback) {}
  constexpr Subscriber(const char* topic, CallbackT callback, Object* object, int = ID_SUBSCRIBER)
      : Endpoint(topic, &drive), callback_(callback, object) {}

  int getEndpointType() const { return ID_SUBSCRIBER; }

  // Runs the callback for a message whose bytes are known to be valid, for tests (see Message::deserialize).
  void callback(unsigned char* data) {
    M message;
    Reader reader(data);
    WireFormat<M>::read(reader, message);
    if (reader.ok()) callback_(message);
  }

 private:
  static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
    if (reader) return static_cast<Subscriber&>(self).receive(node, *reader);
    node.announce(self, ID_SUBSCRIBER, WireFormat<M>::names());
  }
  // A separate function, so that an announcement needs no message on the stack.
  ROS_NOINLINE void receive(NodeHandleBase_& node, Reader& reader) {
    M message;
    WireFormat<M>::read(reader, message);
    if (node.accept(reader)) callback_(message);
  }

  Callback<Object, const M&> callback_;
};

}  // namespace ros

#endif
