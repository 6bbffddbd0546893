#ifndef TF_TRANSFORM_BROADCASTER_H_
#define TF_TRANSFORM_BROADCASTER_H_

#include "geometry_msgs/TransformStamped.h"
#include "ros.h"
#include "tf/tfMessage.h"

namespace tf {

// Publishes transforms between coordinate frames to /tf, one per message.
class TransformBroadcaster {
 public:
  TransformBroadcaster() : publisher_("/tf", &message_) {}

  void init(ros::NodeHandleBase_& node) { node.advertise(publisher_); }

  // Returns the same as Publisher::publish.
  int sendTransform(geometry_msgs::TransformStamped& transform) {
    message_.transforms_length = 1;
    message_.transforms = &transform;
    return publisher_.publish(&message_);
  }

 private:
  tfMessage message_;
  ros::Publisher publisher_;
};

}  // namespace tf

#endif
