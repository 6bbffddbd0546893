// The part of Mbed 2 and Mbed OS 5 that the library uses. cortexm/mbed_kit.cpp implements it for a simulated board.
#ifndef STUB_MBED_H_
#define STUB_MBED_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum PinName { USBTX, USBRX, p13, p14 };

namespace mbed {

template <class Signature>
class Callback;
template <>
class Callback<void()> {
 public:
  Callback() : object_(nullptr), method_(), call_(nullptr) {}
  template <class T>
  Callback(T* object, void (T::*method)()) : object_(object), method_(), call_(&run<T>) {
    static_assert(sizeof method <= sizeof method_, "a pointer to a method is larger here");
    memcpy(method_, &method, sizeof method);
  }
  void operator()() const { call_(object_, method_); }

 private:
  template <class T>
  static void run(void* object, const char* bytes) {
    void (T::*method)();
    memcpy(&method, bytes, sizeof method);
    (static_cast<T*>(object)->*method)();
  }

  void* object_;
  char method_[16];
  void (*call_)(void* object, const char* method);
};

template <class T>
Callback<void()> callback(T* object, void (T::*method)()) {
  return Callback<void()>(object, method);
}

class SerialBase {
 public:
  enum IrqType { RxIrq = 0, TxIrq };
  void baud(int baudrate);
  int readable();
  void attach(Callback<void()> function, IrqType type = RxIrq);
};

class RawSerial : public SerialBase {
 public:
  RawSerial(PinName tx, PinName rx, int baud = 9600);
  int getc();
  int putc(int c);
};

class Timer {
 public:
  void start();
  int read_us();

 private:
  uint32_t began_us_;
};

}  // namespace mbed

using namespace mbed;

#endif
