// OpenCR, the board of the TurtleBot3: an Arduino whose Serial is its USB port, with memory for larger messages.
// USB accepts any baud rate.
#ifndef ROS_PLATFORM_OPENCR_H_
#define ROS_PLATFORM_OPENCR_H_

#include "ros/platform/arduino.h"

#if !defined(ROS_INPUT_SIZE)
#define ROS_INPUT_SIZE 1024
#endif

#endif
