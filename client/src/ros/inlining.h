// Attributes that choose where the compiler puts code.
#ifndef ROS_INLINING_H_
#define ROS_INLINING_H_

#define ROS_NOINLINE __attribute__((noinline))
// A separate function that accesses its object only through `this`. GCC may insert the address of a single object;
// then each access needs four bytes of code on an AVR instead of two.
#if defined(__GNUC__) && !defined(__clang__)
#define ROS_APART __attribute__((noinline, noclone))
#else
#define ROS_APART __attribute__((noinline))
#endif
// Hides the target of a pointer from the compiler: like ROS_APART, but works in inlined functions too.
#define ROS_CONCEAL(pointer) asm("" : "+r"(pointer))
// All functions that this function calls are inlined, except ROS_NOINLINE ones.
#define ROS_FLATTEN __attribute__((flatten))

#endif
