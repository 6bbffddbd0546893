// Arduino finds a library by a header with the library's name. Sketches include ros.h.
#ifndef ROS_LIB_H_
#define ROS_LIB_H_

#include "ros.h"

#endif
