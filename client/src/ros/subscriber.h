#ifndef ROS_SUBSCRIBER_H_
#define ROS_SUBSCRIBER_H_

#include "callback.h"
#include "node_handle_base.h"

namespace ros {

// Runs a callback, a function or a member function of an object, for each message of a topic.
// Strings and arrays of the message point into the receive buffer: copy what is wanted after the callback.
template <class M, class Object = void>
class Subscriber : public Endpoint {
 public:
  typedef typename Callback<Object, const M&>::Function CallbackT;

  constexpr Subscriber(const char* topic, CallbackT callback, int = ID_SUBSCRIBER)
      : Endpoint(topic, &drive), callback_(callback) {}
  constexpr Subscriber(const char* topic, CallbackT callback, Object* object, int = ID_SUBSCRIBER)
      : Endpoint(topic, &drive), callback_(callback, object) {}

  int getEndpointType() const { return ID_SUBSCRIBER; }

 private:
  static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
    M message;
    if (!reader) {
      node.announceReceiver(ID_SUBSCRIBER, self.topic_, self.id_, &message);
      return;
    }
    WireFormat<M>::read(*reader, message);
    if (node.accept(*reader)) static_cast<Subscriber&>(self).callback_(message);
  }

  Callback<Object, const M&> callback_;
};

}  // namespace ros

#endif
