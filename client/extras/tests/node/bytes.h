// Payloads and frames, as the host writes and reads them. This code is independent of the library, so that each checks
// the other.
#ifndef BYTES_H_
#define BYTES_H_

#include <stdint.h>
#include <string.h>

#include <string>
#include <vector>

typedef std::vector<uint8_t> Bytes;

class Payload {
 public:
  template <class T>
  Payload& value(const T& number) {
    const uint8_t* start = reinterpret_cast<const uint8_t*>(&number);
    bytes_.insert(bytes_.end(), start, start + sizeof number);
    return *this;
  }
  Payload& u8(uint8_t number) { return value(number); }
  Payload& u16(uint16_t number) { return value(number); }
  Payload& u32(uint32_t number) { return value(number); }
  Payload& text(const std::string& text) {
    u32(static_cast<uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    return *this;
  }
  operator const Bytes&() const { return bytes_; }

 private:
  Bytes bytes_;
};

inline Bytes frame(uint16_t id, const Bytes& payload = Bytes()) {
  Bytes bytes = {0xff, 0xfe, static_cast<uint8_t>(payload.size()), static_cast<uint8_t>(payload.size() >> 8)};
  bytes.push_back(static_cast<uint8_t>(255 - (bytes[2] + bytes[3])));
  bytes.push_back(static_cast<uint8_t>(id));
  bytes.push_back(static_cast<uint8_t>(id >> 8));
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  uint8_t sum = 0;
  for (size_t i = 5; i < bytes.size(); ++i) sum = static_cast<uint8_t>(sum + bytes[i]);
  bytes.push_back(static_cast<uint8_t>(255 - sum));
  return bytes;
}

inline Bytes operator+(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

struct Frame {
  uint16_t id;
  Bytes payload;
};

struct TopicInfo {
  uint16_t role, id;
  std::string topic, type, md5sum;
  uint32_t buffer_bytes;
};

// Reads values, one after the other, from a payload that the library wrote.
class Parser {
 public:
  explicit Parser(const Bytes& bytes) : bytes_(bytes), at_(0) {}
  template <class T>
  T value() {
    T number;
    if (at_ + sizeof number > bytes_.size()) throw "a payload is too short";
    memcpy(&number, &bytes_[at_], sizeof number);
    at_ += sizeof number;
    return number;
  }
  std::string text() {
    const uint32_t length = value<uint32_t>();
    if (at_ + length > bytes_.size()) throw "a payload is too short";
    const std::string text(bytes_.begin() + static_cast<long>(at_), bytes_.begin() + static_cast<long>(at_ + length));
    at_ += length;
    return text;
  }
  bool atEnd() const { return at_ == bytes_.size(); }

 private:
  const Bytes& bytes_;
  size_t at_;
};

inline TopicInfo topicInfo(const Frame& frame) {
  Parser parser(frame.payload);
  TopicInfo info;
  info.role = frame.id;
  info.id = parser.value<uint16_t>();
  info.topic = parser.text();
  info.type = parser.text();
  info.md5sum = parser.text();
  info.buffer_bytes = parser.value<uint32_t>();
  if (!parser.atEnd()) throw "a TopicInfo is too long";
  return info;
}

inline bool operator==(const Bytes& bytes, const Payload& payload) { return bytes == static_cast<const Bytes&>(payload); }

inline std::string show(const Bytes& bytes) {
  static const char digits[] = "0123456789abcdef";
  std::string text;
  for (size_t i = 0; i < bytes.size() && i < 64; ++i) text = text + digits[bytes[i] >> 4] + digits[bytes[i] & 15];
  return bytes.size() > 64 ? text + "..." : text;
}

#endif
