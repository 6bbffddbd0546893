// Arduino looks libraries up by a header that is called like them; sketches include ros.h.
#ifndef ROS_LIB_H_
#define ROS_LIB_H_

#include "ros.h"

#endif
