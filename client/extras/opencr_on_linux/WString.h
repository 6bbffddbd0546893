// Arduino's String: the part that sketches use for lines of text.
#ifndef OPENCR_ON_LINUX_WSTRING_H_
#define OPENCR_ON_LINUX_WSTRING_H_

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEC 10
#define HEX 16
#define OCT 8
#define BIN 2

class String {
 public:
  String(const char* text = "") : text_(nullptr), length_(0) { append(text, strlen(text)); }
  String(const String& other) : text_(nullptr), length_(0) { append(other.text_, other.length_); }
  explicit String(char letter) : text_(nullptr), length_(0) { append(&letter, 1); }
  explicit String(unsigned char number, int base = DEC) : String(static_cast<unsigned long>(number), base) {}
  explicit String(int number, int base = DEC) : String(static_cast<long>(number), base) {}
  explicit String(unsigned int number, int base = DEC) : String(static_cast<unsigned long>(number), base) {}
  explicit String(long number, int base = DEC) : text_(nullptr), length_(0) {
    const bool is_negative = number < 0 && base == DEC;
    if (is_negative) append("-", 1);
    appendDigits(is_negative ? 0ul - static_cast<unsigned long>(number) : static_cast<unsigned long>(number), base);
  }
  explicit String(unsigned long number, int base = DEC) : text_(nullptr), length_(0) { appendDigits(number, base); }
  explicit String(double number, int decimals = 2) : text_(nullptr), length_(0) {
    char text[352];  // the largest double has 309 digits
    const int size = snprintf(text, sizeof text, "%.*f", decimals < 0 ? 0 : decimals > 32 ? 32 : decimals, number);
    append(text, static_cast<size_t>(size));
  }
  ~String() { free(text_); }

  String& operator=(const String& other) {
    if (this != &other) {
      length_ = 0;
      append(other.text_, other.length_);
    }
    return *this;
  }
  String& operator+=(const String& other) {
    const String copy(other);  // a text may be added to itself
    append(copy.text_, copy.length_);
    return *this;
  }
  String& operator+=(char letter) {
    append(&letter, 1);
    return *this;
  }
  template <typename Number>
  String& operator+=(Number number) { return *this += String(number); }

  const char* c_str() const { return text_; }
  unsigned int length() const { return static_cast<unsigned int>(length_); }
  char charAt(unsigned int at) const { return at < length_ ? text_[at] : '\0'; }
  char operator[](unsigned int at) const { return charAt(at); }
  bool equals(const String& other) const { return strcmp(text_, other.text_) == 0; }
  bool startsWith(const String& start) const { return strncmp(text_, start.text_, start.length_) == 0; }
  bool endsWith(const String& end) const {
    return end.length_ <= length_ && strcmp(text_ + length_ - end.length_, end.text_) == 0;
  }
  int indexOf(const String& part, unsigned int from = 0) const {
    const char* found = from <= length_ ? strstr(text_ + from, part.text_) : nullptr;
    return found ? static_cast<int>(found - text_) : -1;
  }
  int indexOf(char letter, unsigned int from = 0) const { return indexOf(String(letter), from); }
  String substring(unsigned int from) const { return substring(from, length()); }
  String substring(unsigned int from, unsigned int to) const {
    String part;
    if (to > length_) to = length();
    if (from < to) part.append(text_ + from, to - from);
    return part;
  }
  long toInt() const { return atol(text_); }
  float toFloat() const { return static_cast<float>(atof(text_)); }
  void toCharArray(char* buffer, unsigned int size) const {
    if (size) snprintf(buffer, size, "%s", text_);
  }

 private:
  void append(const char* text, size_t size) {
    char* const longer = static_cast<char*>(realloc(text_, length_ + size + 1));
    if (!longer) abort();
    text_ = longer;
    memcpy(text_ + length_, text, size);
    length_ += size;
    text_[length_] = '\0';
  }
  void appendDigits(unsigned long number, int base) {
    if (base < 2 || base > 36) base = DEC;
    char digits[64];
    size_t start = sizeof digits;
    do {
      digits[--start] = "0123456789abcdefghijklmnopqrstuvwxyz"[number % static_cast<unsigned long>(base)];
      number /= static_cast<unsigned long>(base);
    } while (number);
    append(digits + start, sizeof digits - start);
  }

  char* text_;
  size_t length_;
};

inline bool operator==(const String& one, const String& other) { return one.equals(other); }
inline bool operator!=(const String& one, const String& other) { return !one.equals(other); }
template <typename Part>
inline String operator+(String text, const Part& part) {
  text += part;
  return text;
}
inline String operator+(const char* start, const String& text) { return String(start) += text; }

#endif
