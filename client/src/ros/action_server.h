// ros::ActionServer: a long task with feedback and a result, which can be canceled.
//
// It uses the five topics of actionlib: it receives goal and cancel, and sends feedback, result and status. Programs
// with actionlib can call the action. With `rostether serve --ros2` it is also an action of ROS 2.
#ifndef ROS_ACTION_SERVER_H_
#define ROS_ACTION_SERVER_H_

#include <stdint.h>
#include <string.h>

#include "ros/action_server_base.h"
#include "ros/callback.h"

namespace ros {

// Action is the class generated from the definition, for example actionlib_tutorials::FibonacciAction. The callback, a
// function or a member function of an Object, starts a goal. The sketch works on the goal in loop(), and ends it with
// setSucceeded, setAborted or setPreempted. There is one goal at a time: a new goal preempts the previous one.
// ID_BYTES is the size of the buffer for a goal's id, including its final zero.
template <class Action, class Object = void, uint8_t ID_BYTES = 80>
class ActionServer : public ActionServerBase_ {
 public:
  typedef typename Action::_action_goal_type ActionGoal;
  typedef typename Action::_action_feedback_type ActionFeedback;
  typedef typename Action::_action_result_type ActionResult;
  typedef typename ActionGoal::_goal_type Goal;
  typedef typename ActionFeedback::_feedback_type Feedback;
  typedef typename ActionResult::_result_type Result;
  typedef typename Callback<Object, const Goal&>::Function CallbackT;

  ActionServer(const char* action, CallbackT callback) : ActionServerBase_(action, &drive, id_text_), callback_(callback) {}
  ActionServer(const char* action, CallbackT callback, Object* object)
      : ActionServerBase_(action, &drive, id_text_), callback_(callback, object) {}

  // Publishes feedback on the goal in progress. Returns the same as Publisher::publish; 0 if there is no goal.
  int publishFeedback(const Feedback& feedback) { return checkActive() ? send(FEEDBACK, goal_, status_, feedback, "") : 0; }

  // Ends the goal in progress with its result. Returns the same as Publisher::publish; 0 if there is no goal.
  int setSucceeded(const Result& result = Result(), const char* text = "") { return end(Status::SUCCEEDED, result, text); }
  int setAborted(const Result& result = Result(), const char* text = "") { return end(Status::ABORTED, result, text); }
  int setPreempted(const Result& result = Result(), const char* text = "") { return end(Status::PREEMPTED, result, text); }

 private:
  static void drive(Endpoint& self, NodeHandleBase_& node, Reader* reader) {
    if (reader) return static_cast<ActionServer&>(self).receive(node, *reader);
    static const char goal[] ROS_FLASH = "/goal";
    static const char feedback[] ROS_FLASH = "/feedback";
    static const char result[] ROS_FLASH = "/result";
    announce(self, node, ID_SUBSCRIBER, GOAL, goal, WireFormat<ActionGoal>::names());
    announce(self, node, ID_PUBLISHER, FEEDBACK, feedback, WireFormat<ActionFeedback>::names());
    announce(self, node, ID_PUBLISHER, RESULT, result, WireFormat<ActionResult>::names());
    announceStatus(self, node);
  }

  // A separate function, so that an announcement needs no goal on the stack.
  ROS_NOINLINE void receive(NodeHandleBase_& node, Reader& reader) {
    GoalID id;
    readGoalStart(reader, id);
    Goal goal;
    WireFormat<Goal>::read(reader, goal);
    if (!node.accept(reader)) return;
    if (strlen(id.id) >= ID_BYTES) {
      send(RESULT, id, Status::REJECTED, Result(), "the goal's id is too long for the board");
      return;
    }
    end(Status::PREEMPTED, Result(), "replaced by a new goal");
    start(id);
    callback_(goal);
  }

  ROS_APART int end(uint8_t status, const Result& result, const char* text) {
    if (!checkActive()) return 0;
    status_ = status;
    const int sent = send(RESULT, goal_, status, result, text);
    publishStatus();
    return sent;
  }

  // Sends feedback on a goal, or its result.
  template <class Content>
  ROS_APART int send(Place place, const GoalID& goal, uint8_t status, const Content& content, const char* text) {
    const typename WireFormat<Content>::Written written(content);
    const int bytes = begin(place, goal, status, text, written.length());
    if (bytes <= 0) return bytes;
    written.write(*nh_);
    return nh_->finish() ? bytes : -1;
  }

  Callback<Object, const Goal&> callback_;
  char id_text_[ID_BYTES];
};

}  // namespace ros

#endif
