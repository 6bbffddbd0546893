// Attributes that choose where the compiler puts code.
#ifndef ROS_INLINING_H_
#define ROS_INLINING_H_

#define ROS_NOINLINE __attribute__((noinline))
// A separate function that knows its object only as `this`. With the object's address built in, as GCC does where there is
// only one, each access takes an AVR four bytes of code instead of two.
#if defined(__GNUC__) && !defined(__clang__)
#define ROS_APART __attribute__((noinline, noclone))
#else
#define ROS_APART __attribute__((noinline))
#endif
// Hides from the compiler where a pointer points to. Like ROS_APART, but also for functions that are inlined into others.
#define ROS_CONCEAL(pointer) asm("" : "+r"(pointer))
// Everything that the function calls, and is not ROS_NOINLINE, becomes part of it.
#define ROS_FLATTEN __attribute__((flatten))

#endif
