// The node's part of the protocol, independent of the hardware: endpoints, negotiation, time, logs.
#ifndef ROS_NODE_HANDLE_BASE_H_
#define ROS_NODE_HANDLE_BASE_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "ros/endpoint.h"
#include "ros/flash.h"
#include "ros/frame_writer.h"
#include "ros/inlining.h"
#include "ros/time.h"
#include "ros/topic_id.h"
#include "ros/wire_format.h"

namespace ros {

const int SPIN_OK = 0;
const int SPIN_ERR = -1;
const int SPIN_TIMEOUT = -2;

class Publisher;
template <class Request, class Response, class Object>
class ServiceServer;
template <class Request, class Response>
class ServiceClient;
template <class Action, class Object, uint8_t ID_BYTES>
class ActionServer;

class NodeHandleBase_ : public FrameWriter {
 public:
  // Handles the received bytes and runs callbacks. Returns SPIN_OK; SPIN_ERR if the host requested the topics;
  // SPIN_TIMEOUT if the time limit ended it before all bytes were handled.
  virtual int spinOnce() = 0;

  // Whether a host is connected and knows this node's topics.
  bool connected() const { return connected_; }

  // Sets the longest time for which spinOnce reads a line that never pauses; 0 restores the default, 1 s.
  void setSpinTimeout(const uint32_t& timeout_ms) {
    spin_timeout_ms_ = timeout_ms == 0 ? SPIN_TIMEOUT_MS : timeout_ms > 0xffff ? 0xffff : static_cast<uint16_t>(timeout_ms);
  }

  // The number (modulo 65536) of received frames that were dropped because of damage, a wrong length or an unknown
  // topic, and of messages that were not sent because they were too long or the line did not accept them.
  uint16_t dropped() const { return window_.dropped(); }

  // The host's time; before its first answer, the time since the board started.
  Time now() {
    const Moment& moment = clock_.at(time());
    Time now;
    now.sec = moment.sec;
    now.nsec = moment.nsec;
    return now;
  }
  void setNow(const Time& moment) { clock_.set(moment, time()); }

  bool advertise(Publisher& publisher);
  template <class Subscriber>
  bool subscribe(Subscriber& subscriber) {
    return add(subscriber, 1);
  }
  template <class Request, class Response, class Object>
  bool advertiseService(ServiceServer<Request, Response, Object>& server) {
    return add(server, 2);
  }
  template <class Request, class Response>
  bool serviceClient(ServiceClient<Request, Response>& client) {
    client.nh_ = this;
    return add(client, 2);
  }
  // For ros::ActionServer, which needs ros/action_server.h.
  template <class Action, class Object, uint8_t ID_BYTES>
  bool advertiseAction(ActionServer<Action, Object, ID_BYTES>& server) {
    server.nh_ = this;
    return add(server, 4) && add(server.cancels_, 1);
  }

  // Announces all topics and services to the host.
  ROS_APART void negotiateTopics() {
    for (Endpoint* endpoint = endpoints_; endpoint; endpoint = endpoint->next_) endpoint->driver_(*endpoint, *this, nullptr);
    connected_ = true;
  }

  ROS_APART void requestSyncTime() {
    requested_ms_ = shortTime();
    awaiting_time_ = true;
    begin(ID_TIME, 8);
    // A Time that the host ignores.
    count(0);
    count(0);
    finish();
  }

  void logdebug(const char* text) { log(0, text); }
  void loginfo(const char* text) { log(1, text); }
  void logwarn(const char* text) { log(2, text); }
  void logerror(const char* text) { log(3, text); }
  void logfatal(const char* text) { log(4, text); }
  // The same for F("..."), a text that stays in flash.
  void logdebug(const __FlashStringHelper* text) { log(0, flashText(text)); }
  void loginfo(const __FlashStringHelper* text) { log(1, flashText(text)); }
  void logwarn(const __FlashStringHelper* text) { log(2, flashText(text)); }
  void logerror(const __FlashStringHelper* text) { log(3, flashText(text)); }
  void logfatal(const __FlashStringHelper* text) { log(4, flashText(text)); }

  // `text` is a const char* or a FlashText.
  template <class Text>
  ROS_APART void log(uint8_t level, Text text) {
    const size_t length = 5 + lengthOf(text);
    if (isTooLong(length)) return;
    begin(ID_LOG, static_cast<uint16_t>(length));
    byte(level);
    string(text);
    finish();
  }

  // Gets a parameter with `length` values from the host's parameter server. Returns false and logs a warning on the
  // host if the parameter does not have `length` values of this type, or if there is no answer within `timeout_ms`.
  //
  // The form with char** copies each text to a buffer that must be large enough. The form with `text_bytes` cuts a text
  // that is too long for its buffer.
  bool getParam(const char* name, int* values, int length = 1, int timeout_ms = 1000);
  bool getParam(const char* name, float* values, int length = 1, int timeout_ms = 1000);
  bool getParam(const char* name, bool* values, int length = 1, int timeout_ms = 1000);
  bool getParam(const char* name, char** values, int length = 1, int timeout_ms = 1000);
  bool getParam(const char* name, char* text, size_t text_bytes, int timeout_ms = 1000);

  // Sends a message. Returns the number of bytes sent; 0 without a host; -1 if the message is too long for a frame or
  // was not accepted by the line.
  template <class M>
  ROS_APART int send(uint16_t id, const M& message) {
    if (!checkConnected()) return 0;
    const typename WireFormat<M>::Written written(message);
    const size_t length = written.length();
    if (isTooLong(length)) return -1;
    begin(id, static_cast<uint16_t>(length));
    written.write(*this);
    return finish() ? static_cast<int>(length + FRAME_OVERHEAD_BYTES) : -1;
  }

  // The same for a message of any form; `id` is the `id_` of a publisher.
  template <class M>
  int publish(int id, const M* message) {
    return send<typename WireFormat<M>::Class>(static_cast<uint16_t>(id), *message);
  }

  // The longest message that can be received.
  uint16_t largestMessage() const { return window_.largestPayload(); }

  // For drivers: returns whether a host is connected. If not, it first handles the received bytes: after a reset, the
  // host's answer may be among them. So a sketch that publishes, spins and then sleeps need not sleep again before its
  // first message.
  bool checkConnected() {
    if (!connected_) spinOnce();
    return connected_;
  }

  // For drivers: returns whether a message is too long for any frame, and then counts it as dropped.
  bool isTooLong(size_t length) {
    if (length <= 0xffff - FRAME_OVERHEAD_BYTES) return false;
    window_.countDropped();
    return true;
  }

  // For drivers: returns whether the reader has read exactly one message. If so, the data of this message stays valid
  // until the driver returns.
  bool accept(const Reader& reader) {
    if (!reader.complete()) {
      window_.countDropped();
      return false;
    }
    window_.keepArena(reader.arenaEnd());
    return true;
  }

  // For drivers: announces an endpoint, or the request or response of a service. `role` is the topic id of the
  // announcement.
  template <class Names>
  ROS_APART void announce(const Endpoint& endpoint, uint8_t role, Names names) {
    begin(role, static_cast<uint16_t>(2 + 4 + strlen(endpoint.topic_) + names.length() + 4));
    ROS_CONCEAL(role);
    // A service sends on the id after the one on which it receives.
    word(static_cast<uint16_t>(endpoint.id_ + (role != ID_PUBLISHER && !receives(role))));
    string(endpoint.topic_);
    names.write(*this);
    ROS_CONCEAL(role);
    // Messages to the host are streamed, so only the length field of a frame limits them.
    count(receives(role) ? window_.largestPayload() : 0xffff);
    finish();
  }

  // For drivers: ends the spinOnce in progress, so that the message's data stays valid until the next one.
  void pauseReading() { window_.hold(); }

  // Adds an endpoint for the lifetime of this object. The endpoint keeps its id, and is the last one in the list: of two
  // endpoints with one id, the older one is answered first.
  class Temporary {
   public:
    Temporary(NodeHandleBase_& node, Endpoint& endpoint) : node_(node), endpoint_(endpoint) { *node.linkTo(nullptr) = &endpoint; }
    ~Temporary() { *node_.linkTo(&endpoint_) = endpoint_.next_; }
    Temporary(const Temporary&) = delete;
    Temporary& operator=(const Temporary&) = delete;

   private:
    NodeHandleBase_& node_;
    Endpoint& endpoint_;
  };

  // The board's clock in milliseconds.
  uint32_t time() override ROS_ABSTRACT;

 protected:
  static const uint16_t SYNC_PERIOD_MS = 2200;

  NodeHandleBase_() { spin_timeout_ms_ = SPIN_TIMEOUT_MS; }

  // Drops all received bytes; the next spinOnce introduces the node to the host.
  ROS_APART void start(uint8_t* buffer, uint16_t buffer_bytes) {
    window_.open(buffer, buffer_bytes);
    contactAgain();
  }

  // Prepares for another host; the next keepInTouch introduces the node to it.
  void contactAgain() {
    connected_ = false;
    unanswered_ = 0;
    due_ = NOTHING_DUE;
    requested_ms_ = static_cast<uint16_t>(shortTime() - SYNC_PERIOD_MS);
  }

  // The time in milliseconds modulo 65536: enough to measure a few seconds, and half the work for an 8-bit processor.
  uint16_t shortTime() { return static_cast<uint16_t>(time()); }
  static uint16_t since(uint16_t then_ms, uint16_t now_ms) { return static_cast<uint16_t>(now_ms - then_ms); }

  // Handles the result of `examine`. Returns false if this spinOnce must read no more bytes.
  bool handle(uint8_t found) {
    if (found == ReceiveWindow::WHOLE_FRAME) {
      if (depth_ == MAX_NESTED_SPINS) return false;
      ++depth_;
      dispatch();
      --depth_;
    }
    return !window_.held();
  }
  bool isOverdue(uint16_t began_ms, uint16_t now_ms) const { return since(began_ms, now_ms) > spin_timeout_ms_; }
  // Whether the rest of a frame in progress was lost.
  bool isTorn(uint16_t now_ms, bool is_reliable) const {
    return !window_.empty() && since(received_ms_, now_ms) >= (is_reliable ? RELIABLE_GAP_MS : GAP_MS);
  }

  // Whether the host has not answered the last requests for the time.
  bool isHostSilent() const { return unanswered_ == MAX_UNANSWERED; }

  // Answers the host's requests for topics. Repeated requests get one answer: a sketch that sleeps finds several
  // requests at once, and an answer to each would look like several resets. Without a request, it requests the time. A
  // host that answers this but does not request the topics has not noticed that the board was reset: then the node
  // announces them.
  ROS_APART int8_t keepInTouch(uint16_t now_ms) {
    uint8_t due = due_;
    due_ = NOTHING_DUE;
    if (window_.readAndClearForeign() && !connected_) due |= PROBED;
    const uint16_t silent_ms = since(requested_ms_, now_ms);
    if (silent_ms < SYNC_PERIOD_MS) {
      if (due == NOTHING_DUE || (due == PROBED && silent_ms <= ANSWER_PAUSE_MS)) return SPIN_OK;
    }
    if (due & ANSWER_DUE) {
      requestSyncTime();
      negotiateTopics();
      unanswered_ = 0;
      return SPIN_ERR;
    }
    if (due & INTRODUCTION_DUE) {
      negotiateTopics();
    } else if (!isHostSilent()) {
      ++unanswered_;
      if (isHostSilent()) connected_ = false;
    }
    requestSyncTime();
    return SPIN_OK;
  }

 private:
  // What keepInTouch must react to, as bits: a host that searches for boards, a time without a request for the topics,
  // and a request for the topics.
  enum Due { NOTHING_DUE = 0, PROBED = 1, INTRODUCTION_DUE = 2, ANSWER_DUE = 4 };

  // The number of requests for the time, one per SYNC_PERIOD_MS, without an answer: the host has disconnected after 9
  // to 11 s.
  static const uint8_t MAX_UNANSWERED = 5;
  // After a gap of this length inside a frame, its rest was lost. This is longer than the pauses of a network, and
  // short enough that the board soon receives again after a wrong length.
  static const uint16_t GAP_MS = 200;
  // TCP loses no byte, but the rest is late while lost packets are sent again: for the fourth time after 3 s.
  static const uint16_t RELIABLE_GAP_MS = 5000;
  // A host that searches for boards sends other version bytes, and so does noise. One answer to a burst is enough.
  static const uint8_t ANSWER_PAUSE_MS = 20;
  // The limit of nested callbacks, each of which waits in a spinOnce. More would need all of an Uno's stack.
  static const uint8_t MAX_NESTED_SPINS = 3;
  // The default time limit of a spinOnce: a line that never pauses must not block loop().
  static const uint16_t SPIN_TIMEOUT_MS = 1000;

  static FlashText flashText(const __FlashStringHelper* text) {
    const FlashText flash = {reinterpret_cast<const char*>(text)};
    return flash;
  }

  // Whether an endpoint receives messages from the host in this role: a subscriber, or the receiving part of a service.
  static bool receives(uint8_t role) { return role & 1; }

  // The pointer in the list that points to `wanted`; the last pointer of the list for nullptr.
  Endpoint** linkTo(const Endpoint* wanted) {
    Endpoint** link = &endpoints_;
    while (*link != wanted) link = &(*link)->next_;
    return link;
  }

  ROS_APART bool add(Endpoint& endpoint, uint8_t ids) {
    if (endpoint.id_) return true;
    *linkTo(nullptr) = &endpoint;
    endpoint.id_ = static_cast<uint16_t>(FIRST_USER_TOPIC + user_topics_);
    user_topics_ = static_cast<uint16_t>(user_topics_ + ids);
    if (connected_) endpoint.driver_(endpoint, *this, nullptr);
    return true;
  }

  static size_t lengthOf(FlashText text) { return ROS_FLASH_LENGTH(text.address); }
  static size_t lengthOf(const char* text) { return strlen(text); }

  // Handles the frame at the front.
  ROS_APART void dispatch() {
    const ReceiveWindow::Taken frame(window_);
    const uint16_t id = frame.id();
    if (id == ID_PUBLISHER) {
      due_ |= ANSWER_DUE;
    } else if (id == ID_TIME && frame.length() == 8) {
      handleTime(frame.payload());
    } else if (id == ID_TX_STOP) {
      connected_ = false;
    } else {
      frame.read(reader_);
      deliver(id);
    }
  }

  ROS_APART void handleTime(const uint8_t* host) {
    const uint32_t now_ms = time();
    // Assumes that the host read its clock halfway between request and answer.
    const uint16_t answer_ms = awaiting_time_ ? since(requested_ms_, static_cast<uint16_t>(now_ms)) / 2 : 0;
    clock_.follow(host, now_ms - answer_ms);
    awaiting_time_ = false;
    unanswered_ = 0;
    if (!connected_) due_ |= INTRODUCTION_DUE;
  }

  void deliver(uint16_t id) {
    for (Endpoint* endpoint = endpoints_; endpoint; endpoint = endpoint->next_) {
      if (endpoint->id_ == id) {
        endpoint->driver_(*endpoint, *this, &reader_);
        return;
      }
    }
    window_.countDropped();
  }
};

ROS_APART inline void FrameWriter::flush() {
  const chunk_length count = static_cast<chunk_length>(chunk_bytes_ - room_);
  to_ -= count;
  if (sending_ && count) sending_ = static_cast<NodeHandleBase_*>(this)->transmit(to_, count);
  room_ = chunk_bytes_;
}

}  // namespace ros

#endif
