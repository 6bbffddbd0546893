// TimeTF: a coordinate frame, with the host's time. Publishes a transform: base_link is one meter in front of odom.
//
// Wiring: none.
// Try it:  rostether serve /dev/ttyACM0          rostether topic echo /tf

#include <ros.h>
#include <ros/time.h>
#include <tf/transform_broadcaster.h>

ros::NodeHandle nh;

geometry_msgs::TransformStamped transform;
tf::TransformBroadcaster broadcaster;

void setup() {
  nh.initNode();
  broadcaster.init(nh);

  transform.header.frame_id = "odom";
  transform.child_frame_id = "base_link";
  transform.transform.translation.x = 1.0;
  transform.transform.rotation.w = 1.0;  // no rotation: x = y = z = 0, w = 1
}

void loop() {
  transform.header.stamp = nh.now();
  broadcaster.sendTransform(transform);
  nh.spinOnce();
  delay(50);
}
