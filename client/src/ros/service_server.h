#ifndef ROS_SERVICE_SERVER_H_
#define ROS_SERVICE_SERVER_H_

#include "ros/callback.h"
#include "ros/node_handle_base.h"

namespace ros {

// Answers calls of a service. The callback fills in the response, which is sent when the callback returns.
template <class Request, class Response, class Object = void>
class ServiceServer : public Endpoint {
 public:
  typedef typename Callback<Object, const Request&, Response&>::Function CallbackT;

  constexpr ServiceServer(const char* service, CallbackT callback) : Endpoint(service, &drive), callback_(callback) {}
  constexpr ServiceServer(const char* service, CallbackT callback, Object* object)
      : Endpoint(service, &drive), callback_(callback, object) {}

  int getEndpointType() const { return ID_SERVICE_SERVER; }

 private:
  static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
    if (reader) return static_cast<ServiceServer&>(self).answer(node, *reader);
    node.announce(self, ID_SERVICE_SERVER, WireFormat<Response>::names());
    node.announce(self, ID_SERVICE_SERVER + 1, WireFormat<Request>::names());
  }
  // A separate function, so that an announcement needs no messages on the stack.
  ROS_NOINLINE void answer(NodeHandleBase_& node, Reader& reader) {
    Request request;
    WireFormat<Request>::read(reader, request);
    if (!node.accept(reader)) return;
    Response response;
    callback_(request, response);
    node.send(id_ + 1, response);
  }

  Callback<Object, const Request&, Response&> callback_;
};

}  // namespace ros

#endif
