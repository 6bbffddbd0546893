#include <library_tests/Lookup.h>
#include <ros.h>
#include <std_msgs/Int16.h>
#include <std_srvs/SetBool.h>

#include "scripted_hardware.h"

typedef ros::ServiceClient<library_tests::LookupRequest, library_tests::LookupResponse> LookupClient;

struct Caller : Board<> {
  LookupClient lookup;
  library_tests::LookupRequest request;
  library_tests::LookupResponse response;
  int calls = 0;
  std::function<void()> answer;

  Caller() : lookup("lookup") {
    node.serviceClient(lookup);
    meet();
    line.silence_ms = 1;
    line.on_frame = [this](const Frame& got) {
      if (got.id == 10) line.send(time(1700000000));
      if (got.id != lookup.id_ + 1) return;
      ++calls;
      if (answer) answer();
    };
  }
  Bytes found(const std::string& name) {
    return frame(lookup.id_, Payload().u8(1).u32(2).text(name).text("second").u32(1).u8(7).text("part").u32(1).value(2.5));
  }
};

TEST(services, a_call_brings_the_response_with_all_its_arrays) {
  Caller caller;
  caller.answer = [&] { caller.line.send(caller.found("first")); };
  caller.request.name = "things";
  EXPECT(caller.lookup.call(caller.request, caller.response));
  EXPECT(caller.response.found);
  EXPECT_EQUAL(caller.response.names_length, 2u);
  EXPECT_EQUAL(std::string(caller.response.names[0]), "first");
  EXPECT_EQUAL(std::string(caller.response.names[1]), "second");
  EXPECT_EQUAL(caller.response.parts_length, 1u);
  EXPECT_EQUAL(caller.response.parts[0].kind, 7);
  EXPECT_EQUAL(static_cast<double>(caller.response.parts[0].values[0]), 2.5);
}

TEST(services, the_response_stays_valid_while_the_sketch_publishes_and_receives) {
  Board<QueueingHardware> board;
  LookupClient lookup("lookup");
  board.node.serviceClient(lookup);
  board.meet();
  board.line.silence_ms = 1;
  const Bytes response =
      frame(lookup.id_, Payload().u8(1).u32(2).text("first").text("second").u32(1).u8(7).text("part").u32(1).value(2.5));
  board.line.on_frame = [&](const Frame& got) {
    if (got.id != lookup.id_ + 1) return;
    board.line.send(response);
    for (int i = 0; i < 100; ++i) board.line.send(frame(4711, Bytes(30, 0xee)));
  };
  library_tests::LookupRequest request;
  library_tests::LookupResponse got;
  EXPECT(lookup.call(request, got));
  const std::string text(1000, 'x');
  for (int i = 0; i < 5; ++i) {
    board.node.loginfo(text.c_str());
    EXPECT_EQUAL(std::string(got.names[0]), "first");
    EXPECT_EQUAL(std::string(got.names[1]), "second");
    EXPECT_EQUAL(std::string(got.parts[0].name), "part");
    EXPECT_EQUAL(static_cast<double>(got.parts[0].values[0]), 2.5);
  }
}

TEST(services, no_response_within_the_time) {
  Caller caller;
  const unsigned long began_ms = caller.line.now_ms;
  EXPECT(!caller.lookup.call(caller.request, caller.response, 300));
  EXPECT(caller.line.now_ms - began_ms >= 300 && caller.line.now_ms - began_ms < 400);
  EXPECT_EQUAL(caller.calls, 1);
  // The default is shorter than the time after which a silent host counts as disconnected.
  const unsigned long again_ms = caller.line.now_ms;
  EXPECT(!caller.lookup.call(caller.request, caller.response));
  EXPECT(caller.line.now_ms - again_ms >= 5000 && caller.line.now_ms - again_ms <= 11000);
  EXPECT(caller.node.connected());
}

TEST(services, a_late_response_is_ignored) {
  Caller caller;
  EXPECT(!caller.lookup.call(caller.request, caller.response, 100));
  caller.line.send(caller.found("late"));
  caller.node.spinOnce();
  caller.answer = [&] { caller.line.send(caller.found("mine")); };
  EXPECT(caller.lookup.call(caller.request, caller.response));
  EXPECT_EQUAL(std::string(caller.response.names[0]), "mine");
}

TEST(services, a_time_answer_does_not_end_a_call) {
  Caller caller;
  caller.answer = [&] { caller.line.send(Board<>::time(1700000001) + caller.found("after")); };
  EXPECT(caller.lookup.call(caller.request, caller.response));
  EXPECT_EQUAL(std::string(caller.response.names[0]), "after");
}

TEST(services, an_invalid_response_does_not_end_a_call) {
  Caller caller;
  caller.answer = [&] {
    caller.line.send(frame(caller.lookup.id_) + frame(caller.lookup.id_, Payload().u8(1).u32(1000).u32(0)) +
                     frame(caller.lookup.id_, Payload().u8(1).u32(0xffffffff).u32(0xffffffff)) + caller.found("good"));
  };
  EXPECT(caller.lookup.call(caller.request, caller.response));
  EXPECT_EQUAL(std::string(caller.response.names[0]), "good");
  EXPECT_EQUAL(caller.node.dropped(), 3);
}

TEST(services, without_a_host_a_call_fails_at_once) {
  Board<> board;
  LookupClient lookup("lookup");
  library_tests::LookupRequest request;
  library_tests::LookupResponse response;
  EXPECT(!lookup.call(request, response));
  board.node.initNode();
  board.node.serviceClient(lookup);
  EXPECT(!lookup.call(request, response));
}

TEST(services, a_host_that_stops_ends_a_call) {
  Caller caller;
  caller.answer = [&] { caller.line.send(frame(11)); };
  const unsigned long began_ms = caller.line.now_ms;
  EXPECT(!caller.lookup.call(caller.request, caller.response));
  EXPECT(caller.line.now_ms - began_ms < 100);
}

class Switch {
 public:
  void set(const std_srvs::SetBoolRequest& request, std_srvs::SetBoolResponse& response) {
    on = request.data;
    response.success = true;
    response.message = on ? "on" : "off";
  }
  bool on = false;
};

TEST(services, a_server_answers_by_function_and_by_member) {
  Board<> board;
  Switch lamp;
  ros::ServiceServer<std_srvs::SetBoolRequest, std_srvs::SetBoolResponse, Switch> member("member", &Switch::set, &lamp);
  ros::ServiceServer<std_srvs::SetBool::Request, std_srvs::SetBool::Response> function(
      "function", [](const std_srvs::SetBoolRequest& request, std_srvs::SetBoolResponse& response) {
        response.success = !request.data;
      });
  board.node.advertiseService(member);
  board.node.advertiseService(function);
  board.meet();
  board.line.send(frame(member.id_, Payload().u8(1)) + frame(function.id_, Payload().u8(1)) +
                  frame(function.id_, Payload().u8(0)));
  board.node.spinOnce();
  EXPECT(lamp.on);
  const std::vector<Frame> frames = board.line.take();
  EXPECT_EQUAL(frames.size(), 3u);
  EXPECT_EQUAL(frames[0].id, member.id_ + 1);
  EXPECT_EQUAL(frames[0].payload, Payload().u8(1).text("on"));
  EXPECT_EQUAL(frames[1].payload, Payload().u8(0).text(""));
  EXPECT_EQUAL(frames[2].payload, Payload().u8(1).text(""));
}

TEST(services, a_damaged_request_is_not_answered) {
  Board<> board;
  Switch lamp;
  ros::ServiceServer<std_srvs::SetBoolRequest, std_srvs::SetBoolResponse, Switch> member("member", &Switch::set, &lamp);
  board.node.advertiseService(member);
  board.meet();
  board.line.send(frame(member.id_) + frame(member.id_, Bytes(2)));
  board.node.spinOnce();
  EXPECT_EQUAL(board.line.take().size(), 0u);
  EXPECT_EQUAL(board.node.dropped(), 2);
}
