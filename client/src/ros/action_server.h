// ros::ActionServer: a long task with feedback and a result, which can be canceled.
//
// The five topics of actionlib: goal and cancel are received; feedback, result and status are sent. Programs with actionlib use it as any
// action, and with `rostether serve --ros2` it is an action of ROS 2 too.
#ifndef ROS_ACTION_SERVER_H_
#define ROS_ACTION_SERVER_H_

#include <stdint.h>
#include <string.h>

#include "actionlib_msgs/GoalID.h"
#include "actionlib_msgs/GoalStatus.h"
#include "actionlib_msgs/GoalStatusArray.h"
#include "ros/callback.h"
#include "ros/node_handle_base.h"

namespace ros {

// Action is the generated class of the definition: actionlib_tutorials::FibonacciAction. The callback, a function or a member
// function of an Object, begins a goal; the sketch works on it in loop(), and ends it by setSucceeded, setAborted or setPreempted.
// One goal at a time: a new goal ends the one before as preempted. ID_BYTES hold the goal's id with its final zero.
template <class Action, class Object = void, uint8_t ID_BYTES = 80>
class ActionServer : public Endpoint {
 public:
  typedef typename Action::_action_goal_type ActionGoal;
  typedef typename Action::_action_feedback_type ActionFeedback;
  typedef typename Action::_action_result_type ActionResult;
  typedef typename ActionGoal::_goal_type Goal;
  typedef typename ActionFeedback::_feedback_type Feedback;
  typedef typename ActionResult::_result_type Result;
  typedef typename Callback<Object, const Goal&>::Function CallbackT;

  constexpr ActionServer(const char* action, CallbackT callback)
      : Endpoint(action, &drive),
        nh_(nullptr),
        cancels_(action, *this),
        callback_(callback),
        id_text_{},
        stamp_(),
        published_ms_(0),
        status_(NO_GOAL) {}
  constexpr ActionServer(const char* action, CallbackT callback, Object* object)
      : Endpoint(action, &drive),
        nh_(nullptr),
        cancels_(action, *this),
        callback_(callback, object),
        id_text_{},
        stamp_(),
        published_ms_(0),
        status_(NO_GOAL) {}

  // Whether a goal is in progress.
  bool isActive() const { return status_ == Status::ACTIVE || status_ == Status::PREEMPTING; }
  // Whether the client has canceled the goal in progress: end it by setPreempted.
  bool isPreemptRequested() const { return status_ == Status::PREEMPTING; }

  // Publishes how far the goal in progress is. As Publisher::publish; 0 if there is no goal.
  int publishFeedback(const Feedback& feedback) {
    if (!isActive()) return 0;
    ActionFeedback message;
    stamp(message.header);
    fill(message.status, "");
    message.feedback = feedback;
    return nh_->send(id_ + FEEDBACK, message);
  }

  // Ends the goal in progress with its result. As Publisher::publish; 0 if there is no goal.
  int setSucceeded(const Result& result = Result(), const char* text = "") { return end(Status::SUCCEEDED, result, text); }
  int setAborted(const Result& result = Result(), const char* text = "") { return end(Status::ABORTED, result, text); }
  int setPreempted(const Result& result = Result(), const char* text = "") { return end(Status::PREEMPTED, result, text); }

  // Publishes the status five times a second, as clients expect it: call it in loop().
  void spinOnce() {
    if (nh_ && static_cast<uint16_t>(nh_->time()) - published_ms_ >= STATUS_PERIOD_MS) publishStatus();
  }

  int getEndpointType() const { return ID_SUBSCRIBER; }

  NodeHandleBase_* nh_;

 private:
  friend class NodeHandleBase_;
  typedef actionlib_msgs::GoalStatus Status;
  // What it publishes has the ids behind the goals'.
  enum { FEEDBACK = 1, RESULT = 2, STATUS = 3 };
  // No goal is ever pending here: each is begun or rejected at once.
  static const uint8_t NO_GOAL = Status::PENDING;
  static const uint16_t STATUS_PERIOD_MS = 200;

  // The topic `cancel`.
  class Cancels : public Endpoint {
   public:
    constexpr Cancels(const char* action, ActionServer& server) : Endpoint(action, &drive), server_(server) {}

   private:
    friend class NodeHandleBase_;
    static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
      static const char suffix[] ROS_FLASH = "/cancel";
      if (!reader) return announce(self, node, ID_SUBSCRIBER, 0, suffix, WireFormat<actionlib_msgs::GoalID>::names());
      actionlib_msgs::GoalID asked;
      WireFormat<actionlib_msgs::GoalID>::read(*reader, asked);
      if (node.accept(*reader)) static_cast<Cancels&>(self).server_.cancel(asked);
    }
    ActionServer& server_;
  };

  static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
    if (reader) return static_cast<ActionServer&>(self).receive(node, *reader);
    static const char goal[] ROS_FLASH = "/goal";
    static const char feedback[] ROS_FLASH = "/feedback";
    static const char result[] ROS_FLASH = "/result";
    static const char status[] ROS_FLASH = "/status";
    announce(self, node, ID_SUBSCRIBER, 0, goal, WireFormat<ActionGoal>::names());
    announce(self, node, ID_PUBLISHER, FEEDBACK, feedback, WireFormat<ActionFeedback>::names());
    announce(self, node, ID_PUBLISHER, RESULT, result, WireFormat<ActionResult>::names());
    announce(self, node, ID_PUBLISHER, STATUS, status, WireFormat<actionlib_msgs::GoalStatusArray>::names());
  }

  // As NodeHandleBase_::announce, for a topic whose name is the action's and a suffix in flash.
  template <class Names>
  static ROS_NOINLINE void announce(const Endpoint& endpoint, NodeHandleBase_& node, uint8_t role, uint8_t place, const char* suffix,
                                    Names names) {
    const size_t action = strlen(endpoint.topic_), rest = ROS_FLASH_LENGTH(suffix);
    node.begin(role, static_cast<uint16_t>(2 + 4 + action + rest + names.length() + 4));
    node.word(static_cast<uint16_t>(endpoint.id_ + place));
    node.count(action + rest);
    node.put(endpoint.topic_, action);
    node.putFlash(suffix, rest);
    names.write(node);
    node.count(role ? node.largestMessage() : 0xffff);
    node.finish();
  }

  // A separate function, so that an announcement has no message on the stack.
  ROS_NOINLINE void receive(NodeHandleBase_& node, Reader& reader) {
    ActionGoal message;
    WireFormat<ActionGoal>::read(reader, message);
    if (!node.accept(reader)) return;
    const actionlib_msgs::GoalID& id = message.goal_id;
    if (strlen(id.id) >= ID_BYTES) {
      Status status;
      status.goal_id = id;
      status.status = Status::REJECTED;
      status.text = "the goal's id is too long for the board";
      sendResult(status, Result());
      return;
    }
    if (isActive()) end(Status::PREEMPTED, Result(), "replaced by a new goal");
    strcpy(id_text_, id.id);
    stamp_ = id.stamp;
    status_ = Status::ACTIVE;
    publishStatus();
    callback_(message.goal);
  }

  // Empty: all goals. A time: also the goals up to then.
  void cancel(const actionlib_msgs::GoalID& asked) {
    if (status_ != Status::ACTIVE) return;
    const bool has_time = asked.stamp.sec || asked.stamp.nsec;
    const bool is_in_time = stamp_.sec < asked.stamp.sec || (stamp_.sec == asked.stamp.sec && stamp_.nsec <= asked.stamp.nsec);
    if (*asked.id ? strcmp(asked.id, id_text_) != 0 && !(has_time && is_in_time) : has_time && !is_in_time) return;
    status_ = Status::PREEMPTING;
    publishStatus();
  }

  int end(uint8_t status, const Result& result, const char* text) {
    if (!isActive()) return 0;
    status_ = status;
    Status message;
    fill(message, text);
    const int sent = sendResult(message, result);
    publishStatus();
    return sent;
  }

  int sendResult(const Status& status, const Result& result) {
    ActionResult message;
    stamp(message.header);
    message.status = status;
    message.result = result;
    return nh_->send(id_ + RESULT, message);
  }

  ROS_NOINLINE void publishStatus() {
    published_ms_ = static_cast<uint16_t>(nh_->time());
    Status status;
    fill(status, "");
    actionlib_msgs::GoalStatusArray message;
    stamp(message.header);
    message.status_list = &status;
    message.status_list_length = status_ == NO_GOAL ? 0 : 1;
    nh_->send(id_ + STATUS, message);
  }

  void stamp(std_msgs::Header& header) { header.stamp = nh_->now(); }
  void fill(Status& status, const char* text) {
    status.goal_id.stamp = stamp_;
    status.goal_id.id = id_text_;
    status.status = status_;
    status.text = text;
  }

  Cancels cancels_;
  Callback<Object, const Goal&> callback_;
  char id_text_[ID_BYTES];
  Time stamp_;
  uint16_t published_ms_;
  uint8_t status_;
};

}  // namespace ros

#endif
