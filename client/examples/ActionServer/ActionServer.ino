// ActionServer: an action, a task that takes time. It computes two Fibonacci numbers a second, and can be canceled.
//
// Wiring:  none.
// Try it:  rostether serve /dev/ttyACM0
//          rostether topic echo /fibonacci/feedback
//          rostether topic pub -1 /fibonacci/goal actionlib_tutorials/FibonacciActionGoal "goal: {order: 10}"
//          rostether topic pub -1 /fibonacci/cancel actionlib_msgs/GoalID "{}"

#include <actionlib_tutorials/FibonacciAction.h>
#include <ros.h>
#include <ros/action_server.h>

const uint8_t MAX_NUMBERS = 20;
const uint16_t STEP_MS = 500;

ros::NodeHandle nh;

int32_t numbers[MAX_NUMBERS] = {0, 1};
uint8_t count;
uint8_t wanted;
unsigned long stepped_ms;

// A goal begins; loop() works on it.
void begin(const actionlib_tutorials::FibonacciGoal& goal);

ros::ActionServer<actionlib_tutorials::FibonacciAction> server("fibonacci", &begin);

void begin(const actionlib_tutorials::FibonacciGoal& goal) {
  if (goal.order < 1 || goal.order + 1 > MAX_NUMBERS) {
    server.setAborted(actionlib_tutorials::FibonacciResult(), "order must be 1 to 19");
    return;
  }
  count = 2;
  wanted = goal.order + 1;
  stepped_ms = millis();
}

// Returns the numbers so far, as feedback or as the result.
template <class Message>
Message soFar() {
  Message message;
  message.sequence = numbers;
  message.sequence_length = count;
  return message;
}

void work() {
  if (server.isPreemptRequested()) {
    server.setPreempted(soFar<actionlib_tutorials::FibonacciResult>());
  } else if (count >= wanted) {
    server.setSucceeded(soFar<actionlib_tutorials::FibonacciResult>());
  } else if (millis() - stepped_ms >= STEP_MS) {
    stepped_ms += STEP_MS;
    numbers[count] = numbers[count - 1] + numbers[count - 2];
    ++count;
    server.publishFeedback(soFar<actionlib_tutorials::FibonacciFeedback>());
  }
}

void setup() {
  nh.initNode();
  nh.advertiseAction(server);
}

void loop() {
  nh.spinOnce();
  server.spinOnce();
  if (server.isActive()) work();
}
