// Arduino's Print, which writes texts and numbers to a line.
#ifndef OPENCR_ON_LINUX_PRINT_H_
#define OPENCR_ON_LINUX_PRINT_H_

#include "WString.h"

class Print {
 public:
  virtual ~Print() {}
  virtual size_t write(uint8_t byte) { return write(&byte, 1); }
  virtual size_t write(const uint8_t* bytes, size_t size) = 0;
  size_t write(const char* text) { return write(reinterpret_cast<const uint8_t*>(text), strlen(text)); }

  size_t print(const String& text) { return write(text.c_str()); }
  size_t print(const char* text) { return write(text); }
  template <typename Number>
  size_t print(Number number) { return print(String(number)); }
  // `format` is the base of an integer, or the number of decimals of a floating point number.
  template <typename Number>
  size_t print(Number number, int format) { return print(String(number, format)); }
  size_t println() { return write("\r\n"); }
  template <typename Value>
  size_t println(const Value& value) { return print(value) + println(); }
  template <typename Number>
  size_t println(Number number, int format) { return print(number, format) + println(); }
};

#endif
