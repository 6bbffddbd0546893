#include <ros.h>
#include <std_msgs/Empty.h>
#include <std_msgs/Int16.h>
#include <std_msgs/String.h>
#include <std_srvs/Trigger.h>

#include "scripted_hardware.h"

struct Robot : Board<> {
  ros::Subscriber<std_msgs::Int16, Robot> numbers;
  ros::Subscriber<std_msgs::String, Robot> texts;
  ros::ServiceClient<std_srvs::TriggerRequest, std_srvs::TriggerResponse> trigger;
  std::vector<int> heard;
  std::function<void(int)> on_number;
  std::function<void(const std_msgs::String&)> on_text;
  int depth = 0, deepest = 0;

  Robot()
      : numbers("numbers", &Robot::hear, this), texts("texts", &Robot::read, this), trigger("trigger") {
    node.subscribe(numbers);
    node.subscribe(texts);
    node.serviceClient(trigger);
    meet();
    line.silence_ms = 1;
  }
  void hear(const std_msgs::Int16& message) {
    heard.push_back(message.data);
    if (++depth > deepest) deepest = depth;
    if (on_number) on_number(message.data);
    --depth;
  }
  void read(const std_msgs::String& message) {
    if (on_text) on_text(message);
  }
  Bytes number(int value) { return frame(numbers.id_, Payload().u16(static_cast<uint16_t>(value))); }
  Bytes text(const std::string& value) { return frame(texts.id_, Payload().text(value)); }
  static Bytes ints(int32_t value) { return frame(6, Payload().u32(1).value(value).u32(0).u32(0)); }
  Bytes triggered(bool success, const std::string& message) {
    return frame(trigger.id_, Payload().u8(success).text(message));
  }
};

TEST(callbacks, member_functions_and_functions) {
  Robot robot;
  robot.line.send(robot.number(-5));
  robot.node.spinOnce();
  EXPECT_EQUAL(robot.heard.size(), 1u);
  EXPECT_EQUAL(robot.heard[0], -5);
}

TEST(callbacks, a_parameter_is_requested_inside_one) {
  Robot robot;
  std::vector<int> got;
  robot.line.on_frame = [&](const Frame& frame) {
    if (frame.id == 6) robot.line.send(robot.number(100) + Robot::ints(42) + robot.number(101));
  };
  robot.on_text = [&](const std_msgs::String& message) {
    int value = 0;
    EXPECT(robot.node.getParam("~p", &value));
    EXPECT_EQUAL(value, 42);
    EXPECT_EQUAL(std::string(message.data), "still here");
    got.push_back(value);
  };
  robot.line.send(robot.text("still here"));
  robot.node.spinOnce();
  EXPECT_EQUAL(got.size(), 1u);
  EXPECT_EQUAL(robot.heard.size(), 2u);
}

TEST(callbacks, a_service_is_called_inside_one) {
  Robot robot;
  std::string answer;
  robot.line.on_frame = [&](const Frame& frame) {
    if (frame.id == robot.trigger.id_ + 1) robot.line.send(robot.number(1) + robot.triggered(true, "done") + robot.number(2));
  };
  robot.on_text = [&](const std_msgs::String& message) {
    std_srvs::TriggerRequest request;
    std_srvs::TriggerResponse response;
    EXPECT(robot.trigger.call(request, response));
    answer = response.message;
    EXPECT_EQUAL(std::string(message.data), "go");
  };
  robot.line.send(robot.text("go"));
  robot.node.spinOnce();
  EXPECT_EQUAL(answer, "done");
  robot.node.spinOnce();
  EXPECT_EQUAL(robot.heard.size(), 2u);
}

TEST(callbacks, nested_parameters_get_their_own_answers) {
  Robot robot;
  robot.line.on_frame = [&](const Frame& frame) {
    if (frame.id != 6) return;
    // The host answers in order; a message arrives between the first request and its answer.
    Parser parser(frame.payload);
    const std::string name = parser.text();
    if (name == "outer") robot.line.send(robot.number(1));
    if (name == "inner") robot.line.send(Robot::ints(1) + Robot::ints(2));
  };
  int inner = 0, outer = 0;
  bool inner_found = false;
  robot.on_number = [&](int) { inner_found = robot.node.getParam("inner", &inner); };
  EXPECT(robot.node.getParam("outer", &outer));
  EXPECT(inner_found);
  EXPECT_EQUAL(outer, 1);
  EXPECT_EQUAL(inner, 2);
}

TEST(callbacks, a_call_within_a_call_of_the_same_client_fails) {
  Robot robot;
  bool nested = true;
  robot.on_number = [&](int) {
    std_srvs::TriggerRequest request;
    std_srvs::TriggerResponse response;
    nested = robot.trigger.call(request, response);
  };
  robot.line.on_frame = [&](const Frame& frame) {
    if (frame.id == robot.trigger.id_ + 1) robot.line.send(robot.number(1) + robot.triggered(true, "mine"));
  };
  std_srvs::TriggerRequest request;
  std_srvs::TriggerResponse response;
  EXPECT(robot.trigger.call(request, response));
  EXPECT_EQUAL(std::string(response.message), "mine");
  EXPECT(!nested);
}

TEST(callbacks, nesting_of_callbacks_that_wait_is_limited) {
  Robot robot;
  robot.on_number = [&](int) {
    int value;
    robot.node.getParam("p", &value, 1, 20);
  };
  for (int i = 0; i < 300; ++i) robot.line.send(robot.number(i));
  for (int i = 0; i < 400 && robot.heard.size() < 300; ++i) robot.node.spinOnce();
  EXPECT_EQUAL(robot.heard.size(), 300u);
  for (int i = 0; i < 300; ++i) EXPECT_EQUAL(robot.heard[static_cast<size_t>(i)], i);
  EXPECT(robot.deepest <= 4);
  EXPECT_EQUAL(robot.node.dropped(), 0);
}

TEST(callbacks, large_messages_fill_the_buffer_while_one_waits) {
  Robot robot;
  std::string seen;
  robot.on_text = [&](const std_msgs::String& message) {
    if (!seen.empty()) return;
    seen = message.data;
    int value = 0;
    // A message that has no room beside the one of this callback is dropped; the answer after it arrives.
    EXPECT(robot.node.getParam("p", &value));
    EXPECT_EQUAL(value, 9);
    EXPECT_EQUAL(std::string(message.data), seen);
  };
  robot.line.on_frame = [&](const Frame& frame) {
    if (frame.id == 6) robot.line.send(robot.text(std::string(450, 'b')) + Robot::ints(9));
  };
  robot.line.send(robot.text(std::string(400, 'a')));
  robot.node.spinOnce();
  EXPECT_EQUAL(seen, std::string(400, 'a'));
  robot.line.send(robot.number(1));
  robot.node.spinOnce();
  EXPECT_EQUAL(robot.heard.size(), 1u);
}

TEST(callbacks, a_nested_spin_returns_when_the_buffer_is_full) {
  Robot robot;
  bool found = true;
  robot.on_text = [&](const std_msgs::String&) {
    int value;
    found = robot.node.getParam("p", &value, 1, 100);
  };
  robot.line.send(robot.text(std::string(508, 'a')) + robot.number(1));
  robot.node.spinOnce();
  EXPECT(!found);
  robot.node.spinOnce();
  EXPECT_EQUAL(robot.heard.size(), 1u);
}

TEST(callbacks, a_callback_may_advertise) {
  Robot robot;
  std_msgs::Empty empty;
  ros::Publisher late("late", &empty);
  robot.on_number = [&](int) {
    robot.node.advertise(late);
    EXPECT_EQUAL(late.publish(&empty), 8);
  };
  robot.line.send(robot.number(1) + robot.number(2));
  robot.node.spinOnce();
  EXPECT_EQUAL(robot.line.take(late.id_).size(), 2u);
}

TEST(callbacks, a_request_for_the_topics_inside_one_ends_only_the_inner_spin) {
  Robot robot;
  int inner = ros::SPIN_OK;
  robot.on_number = [&](int value) {
    if (value == 1) inner = robot.node.spinOnce();
  };
  robot.line.send(robot.number(1) + frame(0) + robot.number(2));
  EXPECT_EQUAL(robot.node.spinOnce(), ros::SPIN_OK);
  EXPECT_EQUAL(inner, ros::SPIN_ERR);
  EXPECT_EQUAL(robot.heard.size(), 2u);
}
