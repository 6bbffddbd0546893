// ros::KeyedClient with a host that sends the standard input at once, and then stays silent or closes the connection:
//   keyed_client KEY stays|leaves < BYTES     prints the refusal's number, a space, and the client's data
//   keyed_client digests                      SHA-256 of 0 to 199 bytes, and HMACs with keys of these lengths
#include <stdio.h>
#include <string.h>
#include <string>

#include "Arduino.h"

inline unsigned long micros() { return millis() * 1000; }

#include <ros/keyed_client.h>

class ScriptedClient {
 public:
  ScriptedClient() : at_(0), stays_(true) {}
  virtual ~ScriptedClient() {}
  virtual int connect(IPAddress, uint16_t) { return 1; }
  virtual int connect(const char*, uint16_t) { return 1; }
  virtual int read() { return at_ < bytes_.size() ? static_cast<unsigned char>(bytes_[at_++]) : -1; }
  virtual size_t write(const uint8_t* bytes, size_t size) {
    said_.append(reinterpret_cast<const char*>(bytes), size);
    return size;
  }
  virtual uint8_t connected() { return stays_; }
  virtual void stop() {}

  std::string bytes_, said_;
  size_t at_;
  bool stays_;
};

static void show(const uint8_t (&digest)[ros::Sha256::DIGEST_BYTES], char end) {
  for (size_t i = 0; i < sizeof digest; ++i) printf("%02x", digest[i]);
  putchar(end);
}

int main(int count, char** arguments) {
  if (count == 2) {
    for (int length = 0; length < 200; ++length) {
      uint8_t digest[ros::Sha256::DIGEST_BYTES];
      ros::Sha256 hash;
      for (int i = 0; i < length; ++i) hash.add(static_cast<uint8_t>(i * 7));
      hash.finish(digest);
      show(digest, ' ');
      const std::string key(static_cast<size_t>(length), 'k');
      ros::HmacSha256 mac(ros::KeyText(key.c_str()));
      mac.text().add("text");
      mac.finish(digest);
      show(digest, '\n');
    }
    return 0;
  }
  ros::KeyedClient<ScriptedClient> client;
  client.setKey(arguments[1], 7);
  client.stays_ = !strcmp(arguments[2], "stays");
  for (int byte; (byte = getchar()) >= 0;) client.bytes_ += static_cast<char>(byte);
  const int made = client.connect(IPAddress(127, 0, 0, 1), 1);
  if (made != (client.refusal() == client.NONE)) return 1;
  // The client must leave the bytes after the hello to ROS.
  printf("%d %u %s", client.refusal(), static_cast<unsigned>(client.bytes_.size() - client.at_), client.said_.c_str());
  return 0;
}
