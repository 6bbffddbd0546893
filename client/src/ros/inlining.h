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
// Ends the declaration of a virtual function that only the most derived class defines. An AVR has virtual tables in
// RAM. Without a definition of a class's first virtual function, the compiler writes no table for the class. Its
// constructor still refers to the table, without effect: optimization removes this.
#if defined(__AVR__) && defined(__OPTIMIZE_SIZE__)
#define ROS_ABSTRACT
#else
#define ROS_ABSTRACT = 0
#endif
// Inlines all functions that this function calls, except ROS_NOINLINE ones.
#define ROS_FLATTEN __attribute__((flatten))

#endif
