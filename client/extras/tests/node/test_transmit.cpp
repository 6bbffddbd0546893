#include <ros.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Int16.h>
#include <std_msgs/String.h>

#include "scripted_hardware.h"

static int heard;
static void hear(const std_msgs::Int16&) { ++heard; }

template <class Hardware>
struct Sender : Board<Hardware> {
  std_msgs::String text;
  ros::Publisher chatter;
  ros::Subscriber<std_msgs::Int16> numbers;
  Sender() : chatter("chatter", &text), numbers("numbers", hear) {
    heard = 0;
    this->node.advertise(chatter);
    this->node.subscribe(numbers);
    this->meet();
  }
};

TEST(transmit, messages_of_all_lengths_are_complete) {
  Sender<PlainHardware> sender;
  for (size_t length = 0; length < 3000; ++length) {
    const std::string text(length, static_cast<char>('a' + length % 26));
    sender.text.data = text.c_str();
    EXPECT_EQUAL(sender.chatter.publish(&sender.text), static_cast<int>(length) + 12);
    const std::vector<Frame> frames = sender.line.take();
    EXPECT_EQUAL(frames.size(), 1u);
    EXPECT_EQUAL(frames[0].payload, Payload().text(text));
  }
}

TEST(transmit, a_message_too_long_for_a_frame_is_not_sent) {
  Sender<PlainHardware> sender;
  const std::string longest(65535 - 8 - 4, 'x'), longer(65535 - 8 - 3, 'x'), huge(200000, 'x');
  sender.text.data = longest.c_str();
  EXPECT_EQUAL(sender.chatter.publish(&sender.text), 65535);
  EXPECT_EQUAL(sender.line.take().size(), 1u);
  const char* const too_long[] = {longer.c_str(), huge.c_str()};
  for (const char* text : too_long) {
    const int dropped = sender.node.dropped();
    sender.text.data = text;
    EXPECT_EQUAL(sender.chatter.publish(&sender.text), -1);
    EXPECT_EQUAL(sender.line.take().size(), 0u);
    EXPECT_EQUAL(sender.node.dropped() - dropped, 1);
  }
}

TEST(transmit, it_continues_to_read_while_the_transmitter_is_full) {
  Sender<QueueingHardware> sender;
  // A line that is equally slow in both directions: while 400 bytes are sent, 20 messages arrive.
  const Bytes number = frame(sender.numbers.id_, Payload().u16(1));
  for (int i = 0; i < 20; ++i) sender.line.sendSlowly(number, 0);
  const std::string text(400, 'x');
  sender.text.data = text.c_str();
  EXPECT_EQUAL(sender.chatter.publish(&sender.text), 412);
  EXPECT(sender.line.arriving.empty());
  EXPECT_EQUAL(heard, 0);
  sender.node.spinOnce();
  EXPECT_EQUAL(heard, 20);
}

TEST(transmit, bytes_wait_in_the_line_while_the_buffer_is_full) {
  Sender<QueueingHardware> sender;
  const Bytes number = frame(sender.numbers.id_, Payload().u16(1));
  for (int i = 0; i < 200; ++i) sender.line.send(number);
  const std::string text(4000, 'x');
  sender.text.data = text.c_str();
  EXPECT_EQUAL(sender.chatter.publish(&sender.text), 4012);
  EXPECT(!sender.line.arriving.empty());
  sender.node.spinOnce();
  EXPECT_EQUAL(heard, 200);
  EXPECT_EQUAL(sender.node.dropped(), 0);
}

TEST(transmit, handled_frames_leave_their_room_to_received_bytes) {
  Board<QueueingHardware, 280> board;
  static ros::Publisher* out;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  out = &chatter;
  ros::Subscriber<std_msgs::String> texts("texts", [](const std_msgs::String& message) { out->publish(&message); });
  board.node.advertise(chatter);
  board.node.subscribe(texts);
  board.meet();
  board.line.send(frame(texts.id_, Payload().text(std::string(140, 'a'))) + frame(0) +
                  frame(texts.id_, Payload().text(std::string(250, 'b'))));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_ERR);
  // All bytes were read while the topics were announced; a UART would have kept only 64 of them.
  EXPECT(board.line.arriving.empty());
  board.node.spinOnce();
  EXPECT_EQUAL(board.line.take(chatter.id_).size(), 2u);
}

TEST(transmit, frames_that_fill_the_buffer_to_its_end_are_handled_at_once) {
  Board<QueueingHardware, 280> board;
  heard = 0;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  ros::Subscriber<std_msgs::Int16> numbers("numbers", hear);
  board.node.advertise(chatter);
  board.node.subscribe(numbers);
  board.meet();
  // A request and half of a message are read while the node publishes; the rest is read while it answers.
  Bytes arriving;
  for (int i = 0; i < 28; ++i) arriving = arriving + frame(numbers.id_, Payload().u16(1));
  const Bytes first(arriving.begin(), arriving.begin() + 5), rest(arriving.begin() + 5, arriving.end());
  board.line.send(frame(0) + first);
  const std::string long_text(100, 'x');
  text.data = long_text.c_str();
  EXPECT(chatter.publish(&text) > 0);
  EXPECT(board.line.arriving.empty());
  board.line.on_frame = [&](const Frame& got) {
    if (got.id == 0) board.line.send(rest);
  };
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_ERR);
  board.node.spinOnce();
  EXPECT_EQUAL(heard, 28);
}

TEST(transmit, a_transmitter_that_accepts_nothing_is_given_up) {
  Sender<QueueingHardware> sender;
  sender.node.getHardware()->stuck = true;
  sender.text.data = "nobody takes this";
  const unsigned long began_ms = sender.line.now_ms;
  EXPECT_EQUAL(sender.chatter.publish(&sender.text), -1);
  EXPECT(sender.line.now_ms - began_ms > 50 && sender.line.now_ms - began_ms < 500);
  EXPECT_EQUAL(sender.node.dropped(), 1);
  EXPECT_EQUAL(sender.line.written.size(), 0u);
  // Later spins do not wait again.
  const unsigned long spun_ms = sender.line.now_ms;
  for (int i = 0; i < 100; ++i) sender.node.spinOnce();
  EXPECT(sender.line.now_ms - spun_ms < 500);
  sender.node.getHardware()->stuck = false;
  EXPECT(sender.chatter.publish(&sender.text) > 0);
}

TEST(transmit, publishing_while_a_callback_runs) {
  static Sender<QueueingHardware>* sender;
  Sender<QueueingHardware> one;
  sender = &one;
  static std::string last;
  ros::Subscriber<std_msgs::String> texts("texts", [](const std_msgs::String& message) {
    // The data of the message stays valid while bytes are read during publish.
    for (int i = 0; i < 3; ++i) sender->chatter.publish(&message);
    last = message.data;
  });
  one.node.subscribe(texts);
  one.line.take();
  const Bytes number = frame(one.numbers.id_, Payload().u16(1));
  const std::string wanted(200, 'e');
  one.line.send(frame(texts.id_, Payload().text(wanted)));
  for (int i = 0; i < 30; ++i) one.line.send(number);
  one.node.spinOnce();
  EXPECT_EQUAL(last, wanted);
  EXPECT_EQUAL(heard, 30);
  const std::vector<Frame> frames = one.line.take(one.chatter.id_);
  EXPECT_EQUAL(frames.size(), 3u);
  for (const Frame& got : frames) EXPECT_EQUAL(got.payload, Payload().text(wanted));
}

TEST(transmit, logs_of_every_level_and_from_flash) {
  Board<> board;
  board.node.initNode();
  board.node.logdebug("d");
  board.node.loginfo("i");
  board.node.logwarn("w");
  board.node.logerror("e");
  board.node.logfatal("f");
  board.node.logfatal("");
  const std::vector<Frame> frames = board.line.take();
  EXPECT_EQUAL(frames.size(), 6u);
  for (uint8_t level = 0; level < 5; ++level) {
    EXPECT_EQUAL(frames[level].id, 7);
    EXPECT_EQUAL(frames[level].payload, Payload().u8(level).text(std::string(1, "diwef"[level])));
  }
  EXPECT_EQUAL(frames[5].payload, Payload().u8(4).text(""));
  const __FlashStringHelper* flash = reinterpret_cast<const __FlashStringHelper*>("from flash");
  board.node.logdebug(flash);
  board.node.loginfo(flash);
  board.node.logwarn(flash);
  board.node.logerror(flash);
  board.node.logfatal(flash);
  const std::vector<Frame> more = board.line.take();
  EXPECT_EQUAL(more.size(), 5u);
  for (uint8_t level = 0; level < 5; ++level) EXPECT_EQUAL(more[level].payload, Payload().u8(level).text("from flash"));
}

TEST(transmit, a_log_too_long_for_a_frame_is_not_sent) {
  Board<> board;
  board.meet();
  const std::string huge(70000, 'x');
  board.node.loginfo(huge.c_str());
  EXPECT(board.line.written.empty());
  EXPECT_EQUAL(board.line.noise, 0u);
  board.node.loginfo("next");
  EXPECT_EQUAL(board.line.take(7).back().payload, Payload().u8(1).text("next"));
}

TEST(transmit, publishing_needs_a_topic_a_host_and_the_right_type) {
  Board<> board;
  std_msgs::String text;
  std_msgs::Int16 number;
  ros::Publisher chatter("chatter", &text);
  text.data = "hello";
  EXPECT_EQUAL(chatter.publish(&text), 0);
  board.node.initNode();
  EXPECT_EQUAL(chatter.publish(&text), 0);
  board.node.advertise(chatter);
  EXPECT_EQUAL(chatter.publish(&text), 0);
  board.node.negotiateTopics();
  board.line.take();
  EXPECT_EQUAL(chatter.publish(&text), 17);
  EXPECT_EQUAL(chatter.publish(&number), -1);
  EXPECT_EQUAL(board.line.take().size(), 1u);
}

TEST(transmit, null_pointers_are_empty_strings_and_arrays) {
  Board<> board;
  sensor_msgs::JointState state;
  ros::Publisher joints("joints", &state);
  board.node.advertise(joints);
  board.meet();
  state.header.frame_id = nullptr;
  EXPECT_EQUAL(joints.publish(&state), 8 + 12 + 4 + 4 * 4);
  char* names[] = {const_cast<char*>("a"), nullptr};
  state.name = names;
  state.name_length = 2;
  EXPECT_EQUAL(joints.publish(&state), 8 + 12 + 4 + 4 * 4 + 5 + 4);
}
