#include <ros.h>
#include <sensor_msgs/Range.h>
#include <std_msgs/Int16.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>

#include "scripted_hardware.h"

static void ignoreInt16(const std_msgs::Int16&) {}
static void ignoreCall(const std_srvs::SetBoolRequest&, std_srvs::SetBoolResponse&) {}

TEST(negotiation, announces_the_endpoints_in_their_order) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  ros::Subscriber<std_msgs::Int16> numbers("numbers", ignoreInt16);
  ros::ServiceServer<std_srvs::SetBoolRequest, std_srvs::SetBoolResponse> server("power", ignoreCall);
  ros::ServiceClient<std_srvs::SetBoolRequest, std_srvs::SetBoolResponse> client("lights");
  board.node.initNode();
  board.node.advertise(chatter);
  board.node.subscribe(numbers);
  board.node.advertiseService(server);
  board.node.serviceClient(client);
  board.line.send(frame(0));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_ERR);
  const std::vector<TopicInfo> infos = board.announced();
  EXPECT_EQUAL(infos.size(), 6u);
  const struct {
    int role;
    const char *topic, *type, *md5sum;
  } wanted[] = {
      {0, "chatter", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1"},
      {1, "numbers", "std_msgs/Int16", "8524586e34fbd7cb1c08c5f5f1ca0e57"},
      {2, "power", "std_srvs/SetBool", "937c9679a518e3a18d831e57125ea522"},
      {3, "power", "std_srvs/SetBool", "8b94c1b53db61fb6aed406028ad6332a"},
      {4, "lights", "std_srvs/SetBool", "8b94c1b53db61fb6aed406028ad6332a"},
      {5, "lights", "std_srvs/SetBool", "937c9679a518e3a18d831e57125ea522"},
  };
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQUAL(infos[i].role, wanted[i].role);
    EXPECT_EQUAL(infos[i].topic, wanted[i].topic);
    EXPECT_EQUAL(infos[i].type, wanted[i].type);
    EXPECT_EQUAL(infos[i].md5sum, wanted[i].md5sum);
    EXPECT(infos[i].id >= 100);
    // Messages from the host must fit in the buffer; messages to it are limited only by the frame.
    EXPECT_EQUAL(infos[i].buffer_bytes, wanted[i].role % 2 ? 512u : 65535u);
    for (size_t j = 0; j < i; ++j) EXPECT(infos[j].id != infos[i].id);
  }
}

TEST(negotiation, requests_the_time_first) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  board.node.initNode();
  board.node.advertise(chatter);
  board.line.send(frame(0));
  board.node.spinOnce();
  const std::vector<Frame> frames = board.line.take();
  EXPECT_EQUAL(frames.size(), 2u);
  EXPECT_EQUAL(frames[0].id, 10);
  EXPECT_EQUAL(frames[0].payload, Bytes(8));
}

TEST(negotiation, without_endpoints_it_only_requests_the_time) {
  Board<> board;
  board.meet();
  board.line.send(frame(0));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_ERR);
  EXPECT_EQUAL(board.line.take().size(), 1u);
}

// A board first requests the time: a host that requests the topics would receive the announcements twice.
TEST(negotiation, introduces_itself_after_a_reset_to_a_host_that_does_not_ask) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  board.node.initNode();
  board.node.advertise(chatter);
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_OK);
  const std::vector<Frame> first = board.line.take();
  EXPECT_EQUAL(first.size(), 1u);
  EXPECT_EQUAL(first[0].id, 10);
  EXPECT(!board.node.connected());
  // A host that was connected all the time answers the time request, and receives messages.
  board.line.send(Board<>::time(1700000000));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_OK);
  const std::vector<Frame> introduction = board.line.take();
  EXPECT_EQUAL(introduction.size(), 2u);
  // By this order, hosts distinguish an introduction from the answer to a request.
  EXPECT_EQUAL(introduction[0].id, 0);
  EXPECT_EQUAL(introduction[1].id, 10);
  EXPECT(board.node.connected());
  text.data = "up again";
  EXPECT_EQUAL(chatter.publish(&text), 8 + 4 + 8);
}

TEST(negotiation, requests_that_arrive_together_are_answered_once) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  ros::Subscriber<std_msgs::Int16> numbers("numbers", ignoreInt16);
  board.node.initNode();
  board.node.advertise(chatter);
  board.node.subscribe(numbers);
  board.node.spinOnce();
  board.line.take();
  // A sketch that has slept for a second finds the requests that the host has repeated meanwhile.
  board.line.send(Board<>::time(1700000000) + frame(0) + frame(0) + frame(0) + frame(0));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_ERR);
  const std::vector<Frame> answer = board.line.take();
  EXPECT_EQUAL(answer.size(), 3u);
  EXPECT_EQUAL(answer[0].id, 10);
  EXPECT_EQUAL(answer[1].id, 0);
  EXPECT_EQUAL(answer[2].id, 1);
  for (int ms = 0; ms < 1000; ++ms) {
    ++board.line.now_ms;
    EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_OK);
  }
  EXPECT_EQUAL(board.line.take().size(), 0u);
  // A later request is a separate one: an announcement may have been lost.
  board.line.send(frame(0));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_ERR);
  EXPECT_EQUAL(board.announced().size(), 2u);
}

TEST(negotiation, a_request_among_messages_is_answered_after_them) {
  Board<> board;
  static int heard;
  heard = 0;
  ros::Subscriber<std_msgs::Int16> numbers("numbers", [](const std_msgs::Int16&) { ++heard; });
  board.node.subscribe(numbers);
  board.meet();
  const Bytes number = frame(numbers.id_, Payload().u16(1));
  board.line.send(number + frame(0) + number);
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_ERR);
  EXPECT_EQUAL(heard, 2);
  EXPECT_EQUAL(board.announced().size(), 1u);
}

TEST(negotiation, a_sketch_that_sleeps_a_second_loses_only_one) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  text.data = "hello";
  board.node.initNode();
  board.node.advertise(chatter);
  board.line.on_frame = [&](const Frame& got) {
    if (got.id == 10) board.line.send(Board<>::time(1700000000));
  };
  for (int second = 0; second < 4; ++second) {
    EXPECT_EQUAL(chatter.publish(&text) > 0, second > 0);
    board.node.spinOnce();
    board.line.now_ms += 1000;
  }
}

TEST(negotiation, asks_again_without_an_answer) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  board.node.initNode();
  board.node.advertise(chatter);
  for (int ms = 0; ms < 30000; ++ms) ++board.line.now_ms, board.node.spinOnce();
  const std::vector<Frame> sent = board.line.take();
  EXPECT(sent.size() >= 12 && sent.size() <= 15);
  for (const Frame& each : sent) EXPECT_EQUAL(each.id, 10);
}

TEST(negotiation, a_second_initNode_starts_again) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  board.node.advertise(chatter);
  board.meet();
  board.line.send({0xff, 0xfe, 0x00, 0x00, 0xff});
  board.node.spinOnce();
  board.node.initNode();
  EXPECT_EQUAL(board.line.begun, 2);
  EXPECT(!board.node.connected());
  board.node.spinOnce();
  EXPECT_EQUAL(board.line.take(10).size(), 1u);
  board.line.send(frame(0));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_ERR);
  EXPECT_EQUAL(board.announced().size(), 1u);
}

TEST(negotiation, advertising_twice_is_advertising_once) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  ros::Subscriber<std_msgs::Int16> numbers("numbers", ignoreInt16);
  board.node.initNode();
  EXPECT(board.node.advertise(chatter));
  EXPECT(board.node.subscribe(numbers));
  EXPECT(board.node.advertise(chatter));
  EXPECT(board.node.subscribe(numbers));
  board.node.negotiateTopics();
  EXPECT_EQUAL(board.announced().size(), 2u);
}

TEST(negotiation, a_later_endpoint_is_announced_at_once) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  ros::Subscriber<std_msgs::Int16> numbers("numbers", ignoreInt16);
  board.node.advertise(chatter);
  board.meet();
  board.node.subscribe(numbers);
  const std::vector<TopicInfo> infos = board.announced();
  EXPECT_EQUAL(infos.size(), 1u);
  EXPECT_EQUAL(infos[0].topic, "numbers");
  EXPECT(infos[0].id != chatter.id_);
}

TEST(negotiation, endpoints_may_precede_initNode) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  board.node.advertise(chatter);
  EXPECT_EQUAL(chatter.publish(&text), 0);
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_OK);
  board.line.take();
  board.meet();
  text.data = "x";
  EXPECT(chatter.publish(&text) > 0);
}

TEST(negotiation, two_hundred_endpoints) {
  Board<> board;
  std::vector<std_msgs::String> messages(200);
  std::deque<ros::Publisher> publishers;
  board.node.initNode();
  for (size_t i = 0; i < messages.size(); ++i) {
    publishers.emplace_back("topic", &messages[i]);
    board.node.advertise(publishers.back());
  }
  board.node.negotiateTopics();
  const std::vector<TopicInfo> infos = board.announced();
  EXPECT_EQUAL(infos.size(), 200u);
  EXPECT_EQUAL(infos[199].id, 299);
}

TEST(negotiation, size_arguments_determine_the_announced_input_size) {
  Board<PlainHardware, 150> board;
  ros::Subscriber<std_msgs::Int16> numbers("numbers", ignoreInt16);
  board.node.initNode();
  board.node.subscribe(numbers);
  board.node.negotiateTopics();
  EXPECT_EQUAL(board.announced()[0].buffer_bytes, 150u);
}

TEST(negotiation, a_message_of_the_announced_size_is_received) {
  Board<PlainHardware, 150> board;
  static size_t length;
  length = 0;
  ros::Subscriber<std_msgs::String> texts("texts", [](const std_msgs::String& message) { length = strlen(message.data); });
  board.node.subscribe(texts);
  board.meet();
  board.line.send(frame(texts.id_, Payload().text(std::string(146, 'a'))));
  board.node.spinOnce();
  EXPECT_EQUAL(length, 146u);
  board.line.send(frame(texts.id_, Payload().text(std::string(147, 'b'))));
  board.node.spinOnce();
  EXPECT_EQUAL(length, 146u);
}
