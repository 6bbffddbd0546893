// The part of an action server that does not depend on the action's type: the goal in progress, its status, and the
// messages about it.
#ifndef ROS_ACTION_SERVER_BASE_H_
#define ROS_ACTION_SERVER_BASE_H_

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "actionlib_msgs/GoalID.h"
#include "actionlib_msgs/GoalStatus.h"
#include "actionlib_msgs/GoalStatusArray.h"
#include "ros/node_handle_base.h"

namespace ros {

// Messages are read and written field by field: message objects would need twice the flash on an AVR.
class ActionServerBase_ : public Endpoint {
 public:
  // Whether a goal is in progress.
  bool isActive() const { return status_ == Status::ACTIVE || status_ == Status::PREEMPTING; }
  // Whether a client has canceled the goal in progress: then end the goal with setPreempted.
  bool isPreemptRequested() const { return status_ == Status::PREEMPTING; }

  // Publishes the status five times a second, as clients expect. Call it in loop().
  void spinOnce() {
    if (nh_ && static_cast<uint16_t>(nh_->time()) - published_ms_ >= STATUS_PERIOD_MS) publishStatus();
  }

  int getEndpointType() const { return ID_SUBSCRIBER; }

  NodeHandleBase_* nh_;

 protected:
  typedef actionlib_msgs::GoalID GoalID;
  typedef actionlib_msgs::GoalStatus Status;
  // The ids of the publishers follow the id of the goal topic in this order.
  enum Place { GOAL, FEEDBACK, RESULT, STATUS };

  ActionServerBase_(const char* action, Driver driver, char* id_text)
      : Endpoint(action, driver), nh_(nullptr), status_(NO_GOAL), cancels_(action, *this), id_text_(id_text), published_ms_(0) {
    goal_.id = id_text;
  }

  // Like NodeHandleBase_::announce, for a topic whose name consists of the action's name and a suffix in flash.
  template <class Names>
  static ROS_APART void announce(const Endpoint& endpoint, NodeHandleBase_& node, uint8_t role, Place place, const char* suffix,
                                 Names names) {
    const size_t action = strlen(endpoint.topic_), rest = ROS_FLASH_LENGTH(suffix);
    node.begin(role, static_cast<uint16_t>(2 + 4 + action + rest + names.length() + 4));
    node.word(static_cast<uint16_t>(endpoint.id_ + place));
    node.count(action + rest);
    node.put(endpoint.topic_, action);
    node.putFlash(suffix, rest);
    names.write(node);
    node.count(role & 1 ? node.largestMessage() : 0xffff);
    node.finish();
  }
  static void announceStatus(const Endpoint& endpoint, NodeHandleBase_& node) {
    static const char status[] ROS_FLASH = "/status";
    announce(endpoint, node, ID_PUBLISHER, STATUS, status, WireFormat<actionlib_msgs::GoalStatusArray>::names());
  }

  // Reads the start of a goal message: a header, which is not used, and the id of the goal.
  static ROS_APART void readGoalStart(Reader& reader, GoalID& id) {
    uint8_t seq_and_stamp[12];
    reader.value(seq_and_stamp);
    reader.string(id.id);
    readId(reader, id);
  }

  // Whether a goal is in progress. Without a host, received bytes are handled first; see checkConnected.
  bool checkActive() {
    nh_->checkConnected();
    return isActive();
  }

  // Starts a goal whose id fits in the buffer.
  ROS_APART void start(const GoalID& id) {
    strcpy(id_text_, id.id);
    goal_.stamp = id.stamp;
    status_ = Status::ACTIVE;
    publishStatus();
  }

  // Writes the part of a message before its content: the header and the status of a goal. Returns the length of the
  // frame in bytes; 0 or -1, like Publisher::publish, if there is no frame.
  ROS_APART int begin(Place place, const GoalID& goal, uint8_t status, const char* text, size_t content_bytes) {
    NodeHandleBase_& node = *nh_;
    if (!node.connected()) return 0;
    size_t length = HEADER_BYTES + content_bytes;
    if (status != NO_GOAL) length += STATUS_BYTES + strlen(goal.id) + strlen(text);
    if (node.isTooLong(length)) return -1;
    node.begin(static_cast<uint16_t>(id_ + place), static_cast<uint16_t>(length));
    const Time now = node.now();
    node.count(0);
    node.put(&now, sizeof now);
    node.count(0);
    if (place == STATUS) node.count(status != NO_GOAL);
    if (status != NO_GOAL) {
      node.put(&goal.stamp, sizeof goal.stamp);
      node.string(goal.id);
      node.byte(status);
      node.string(text);
    }
    return static_cast<int>(length + FRAME_OVERHEAD_BYTES);
  }

  ROS_APART void publishStatus() {
    published_ms_ = static_cast<uint16_t>(nh_->time());
    if (begin(STATUS, goal_, status_, "", 4) > 0) nh_->finish();
  }

  GoalID goal_;
  uint8_t status_;

 private:
  friend class NodeHandleBase_;
  // The bytes of a header and of a status, with empty names and strings.
  static const uint8_t HEADER_BYTES = 16, STATUS_BYTES = 17;
  // No goal ever has the status pending, because each goal is started or rejected immediately.
  static const uint8_t NO_GOAL = Status::PENDING;
  static const uint16_t STATUS_PERIOD_MS = 200;

  // The subscriber of the topic `cancel`.
  class Cancels : public Endpoint {
   public:
    Cancels(const char* action, ActionServerBase_& server) : Endpoint(action, &drive), server_(server) {}

   private:
    static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
      static const char suffix[] ROS_FLASH = "/cancel";
      if (!reader) return announce(self, node, ID_SUBSCRIBER, GOAL, suffix, WireFormat<GoalID>::names());
      GoalID asked;
      readId(*reader, asked);
      if (node.accept(*reader)) static_cast<Cancels&>(self).server_.cancel(asked);
    }
    ActionServerBase_& server_;
  };

  static ROS_APART void readId(Reader& reader, GoalID& id) {
    reader.value(id.stamp);
    reader.string(id.id);
  }

  // Cancels the goal in progress if the request means it. An empty id means all goals. A time also means the goals
  // up to that time.
  void cancel(const GoalID& asked) {
    if (status_ != Status::ACTIVE) return;
    if (!*asked.id || strcmp(asked.id, id_text_) != 0) {
      const bool has_time = asked.stamp != Time();
      if (has_time ? asked.stamp < goal_.stamp : *asked.id) return;
    }
    status_ = Status::PREEMPTING;
    publishStatus();
  }

  Cancels cancels_;
  char* id_text_;
  uint16_t published_ms_;
};

}  // namespace ros

#endif
