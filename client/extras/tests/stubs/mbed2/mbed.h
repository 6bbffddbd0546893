// What the library uses of Mbed 2 and Mbed OS 5.
#ifndef STUB_MBED_H_
#define STUB_MBED_H_

#include <stddef.h>
#include <stdint.h>

enum PinName { USBTX, USBRX, p13, p14 };

namespace mbed {

template <class Signature>
class Callback;
template <>
class Callback<void()> {};

template <class T>
Callback<void()> callback(T* object, void (T::*method)());

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
};

}  // namespace mbed

using namespace mbed;

#endif
