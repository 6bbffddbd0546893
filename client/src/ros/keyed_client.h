// A network client that proves to the host that it has a key before it sends rosserial data, and checks the host's
// proof.
//
//   #define ROSSERIAL_ARDUINO_TCP
//   #include <Ethernet.h>
//   #include <ros.h>
//   #include <ros/keyed_client.h>
//   ...
//   ros::NodeHandle_<ArduinoTcpHardware<ros::KeyedClient<EthernetClient> > > nh;
//   ...
//   nh.getHardware()->client().setKey(F("the text in board.key"));
//
// The host:  rostether serve "tcp://:11411?psk=board.key"
//
// The board refuses hosts without the key. The data is not encrypted, unless NetworkClient is a TLS client.
#ifndef ROS_KEYED_CLIENT_H_
#define ROS_KEYED_CLIENT_H_

#include <Arduino.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/sha256.h"

namespace ros {

// The hello consists of three lines of text:
//
//   host   RSPSK1 NONCE
//   board  RSPSK1 BOARD_NONCE PROOF    PROOF: HMAC-SHA256 of "rostether psk1 connector NONCE BOARD_NONCE"
//   host   RSPSK1 PROOF                the same with "listener" instead of "connector"
//
// A nonce has 16 bytes and a proof has 32, both in hex.
template <class NetworkClient>
class KeyedClient : public NetworkClient {
 public:
  enum Refusal { NONE, NO_ANSWER, NO_HELLO, WRONG_KEY };

  KeyedClient() : seed_(0), refusal_(NONE) {}

  // Sets the key: the text of the key file, which is not copied and must stay valid. `seed` is a value that an attacker
  // cannot know, such as the noise of an open analog input. Without it, an attacker who can start a board at a chosen
  // microsecond could replay the host's lines.
  void setKey(const char* key, uint32_t seed = 0) { set(KeyText(key), seed); }
  void setKey(const __FlashStringHelper* key, uint32_t seed = 0) { set(KeyText(key), seed); }

  // Returns why the hello of the last connection failed: the host sent nothing in time or closed the connection, did
  // not ask for a key, or could not prove that it has this board's key.
  Refusal refusal() const { return refusal_; }

  int connect(IPAddress server, uint16_t port) { return greeted(NetworkClient::connect(server, port)); }
  int connect(const char* server, uint16_t port) { return greeted(NetworkClient::connect(server, port)); }

 private:
  static const uint8_t NONCE_HEX = 32, PROOF_HEX = 64, WORD = 7;
  // The host also waits five seconds.
  static const uint16_t LIMIT_MS = 5000;

  void set(const KeyText& key, uint32_t seed) {
    key_ = key;
    seed_ = seed;
  }

  int greeted(int made) {
    refusal_ = made > 0 ? greet() : NONE;
    if (refusal_ == NONE) return made;
    NetworkClient::stop();
    return 0;
  }

  static const char* word() { return "RSPSK1 "; }

  Refusal greet() {
    char host_nonce[NONCE_HEX + 1], board_nonce[NONCE_HEX + 1], proof[PROOF_HEX + 1], received[PROOF_HEX + 1];
    const uint32_t began_ms = millis();
    Refusal refusal = readLine(host_nonce, NONCE_HEX, began_ms);
    if (refusal != NONE) return refusal;
    makeNonce(host_nonce, board_nonce);
    prove("connector ", host_nonce, board_nonce, proof);
    char line[WORD + NONCE_HEX + 1 + PROOF_HEX + 1];
    memcpy(line, word(), WORD);
    memcpy(line + WORD, board_nonce, NONCE_HEX);
    line[WORD + NONCE_HEX] = ' ';
    memcpy(line + WORD + NONCE_HEX + 1, proof, PROOF_HEX);
    line[sizeof line - 1] = '\n';
    NetworkClient::write(reinterpret_cast<const uint8_t*>(line), sizeof line);
    prove("listener ", host_nonce, board_nonce, proof);
    refusal = readLine(received, PROOF_HEX, began_ms);
    if (refusal != NONE) return refusal;
    uint8_t differing = 0;
    for (uint8_t i = 0; i < PROOF_HEX; ++i) differing |= static_cast<uint8_t>(received[i] ^ proof[i]);
    return differing ? WRONG_KEY : NONE;
  }

  // Reads "RSPSK1 " and the hex digits, and no byte after the end of the line, where rosserial starts.
  Refusal readLine(char* hex, uint8_t digits, uint32_t began_ms) {
    for (uint8_t at = 0; at <= WORD + digits; ++at) {
      int byte = NetworkClient::read();
      while (byte < 0) {
        if (millis() - began_ms >= LIMIT_MS || !NetworkClient::connected()) return NO_ANSWER;
        delay(1);
        byte = NetworkClient::read();
      }
      if (at < WORD ? byte != word()[at] : at == WORD + digits ? byte != '\n' : !isHex(byte)) return NO_HELLO;
      if (at >= WORD && at < WORD + digits) hex[at - WORD] = static_cast<char>(byte);
    }
    hex[digits] = 0;
    return NONE;
  }
  static bool isHex(int byte) { return (byte >= '0' && byte <= '9') || (byte >= 'a' && byte <= 'f'); }

  // A new nonce for each hello: it need not be secret, but must not repeat.
  void makeNonce(const char* host_nonce, char* board_nonce) {
    const uint32_t now_us = micros();
    HmacSha256 mac(key_);
    mac.text().add("nonce ");
    mac.text().add(host_nonce);
    mac.text().add(&now_us, sizeof now_us);
    mac.text().add(&seed_, sizeof seed_);
    uint8_t digest[Sha256::DIGEST_BYTES];
    mac.finish(digest);
    memcpy(&seed_, digest + NONCE_HEX / 2, sizeof seed_);
    toHex(digest, NONCE_HEX, board_nonce);
  }

  void prove(const char* role, const char* host_nonce, const char* board_nonce, char* hex) {
    HmacSha256 mac(key_);
    mac.text().add("rostether psk1 ");
    mac.text().add(role);
    mac.text().add(host_nonce);
    mac.text().add(' ');
    mac.text().add(board_nonce);
    uint8_t digest[Sha256::DIGEST_BYTES];
    mac.finish(digest);
    toHex(digest, PROOF_HEX, hex);
  }

  static void toHex(const uint8_t* bytes, uint8_t digits, char* hex) {
    for (uint8_t i = 0; i < digits; ++i) {
      const uint8_t digit = i % 2 ? bytes[i / 2] & 15 : bytes[i / 2] >> 4;
      hex[i] = static_cast<char>(digit < 10 ? '0' + digit : 'a' + digit - 10);
    }
    hex[digits] = 0;
  }

  KeyText key_;
  uint32_t seed_;
  Refusal refusal_;
};

}  // namespace ros

#endif
