#ifndef ROS_SERVICE_CLIENT_H_
#define ROS_SERVICE_CLIENT_H_

#include <stdint.h>

#include "ros/node_handle_base.h"

namespace ros {

// Calls a service and waits for its response. Other callbacks run meanwhile.
template <class Request, class Response>
class ServiceClient : public Endpoint {
 public:
  constexpr explicit ServiceClient(const char* service) : Endpoint(service, &drive), nh_(nullptr), response_(nullptr) {}

  // Returns true when the response has arrived; false without a host, during another call of this client, or after
  // `timeout_ms`. The default is about the time after which a silent host has disconnected. Strings and arrays of the
  // response stay valid until the next spinOnce.
  bool call(const Request& request, Response& response, uint32_t timeout_ms = 10000) {
    if (!nh_ || response_ || nh_->send(id_ + 1, request) <= 0) return false;
    response_ = &response;
    const uint32_t began_ms = nh_->time();
    while (response_ && nh_->connected() && nh_->time() - began_ms < timeout_ms) nh_->spinOnce();
    const bool answered = !response_;
    response_ = nullptr;
    return answered;
  }

  int getEndpointType() const { return ID_SERVICE_CLIENT; }

  NodeHandleBase_* nh_;

 private:
  static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
    ServiceClient& client = static_cast<ServiceClient&>(self);
    if (!reader) {
      node.announce(self, ID_SERVICE_CLIENT, WireFormat<Request>::names());
      node.announce(self, ID_SERVICE_CLIENT + 1, WireFormat<Response>::names());
    } else if (client.response_) {
      WireFormat<Response>::read(*reader, *client.response_);
      if (!node.accept(*reader)) return;
      client.response_ = nullptr;
      node.pauseReading();
    }
  }

  Response* response_;
};

}  // namespace ros

#endif
