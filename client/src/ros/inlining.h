// What the compiler is told of where to put code, against its own guess.
#ifndef ROS_INLINING_H_
#define ROS_INLINING_H_

#define ROS_NOINLINE __attribute__((noinline))
// Everything that the function calls, and is not ROS_NOINLINE, becomes part of it.
#define ROS_FLATTEN __attribute__((flatten))

#endif
