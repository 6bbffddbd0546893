// Everything that a sketch needs for ROS: `ros::NodeHandle`, publishers, subscribers, services, time.
#ifndef ROS_H_
#define ROS_H_

#include "ros/duration.h"
#include "ros/message.h"
#include "ros/node_handle.h"
#include "ros/time.h"

#include "ros/platform/platform.h"

#endif
