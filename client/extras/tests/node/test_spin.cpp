#include <ros.h>
#include <std_msgs/Int16.h>
#include <std_msgs/String.h>

#include "scripted_hardware.h"

static std::vector<int> heard;
static void hear(const std_msgs::Int16& message) { heard.push_back(message.data); }

struct Listener : Board<> {
  ros::Subscriber<std_msgs::Int16> numbers;
  Listener() : numbers("numbers", hear) {
    heard.clear();
    node.subscribe(numbers);
    meet();
  }
  Bytes number(int value) { return frame(numbers.id_, Payload().u16(static_cast<uint16_t>(value))); }
};

TEST(spin, one_call_handles_all_received_frames) {
  Listener board;
  for (int i = 0; i < 1000; ++i) board.line.send(board.number(i));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_OK);
  EXPECT_EQUAL(heard.size(), 1000u);
  for (int i = 0; i < 1000; ++i) EXPECT_EQUAL(heard[static_cast<size_t>(i)], i);
  EXPECT_EQUAL(board.node.dropped(), 0);
}

TEST(spin, byte_by_byte_with_spins_between) {
  Listener board;
  for (int i = 0; i < 100; ++i) {
    board.line.sendSlowly(board.number(-i), 1);
    for (int ms = 0; ms < 11; ++ms) ++board.line.now_ms, board.node.spinOnce();
  }
  EXPECT_EQUAL(heard.size(), 100u);
}

TEST(spin, a_frame_that_pauses_arrives_as_long_as_its_gaps_are_short) {
  Listener board;
  board.line.sendSlowly(board.number(7), 150);
  for (int ms = 0; ms < 1800; ++ms) ++board.line.now_ms, board.node.spinOnce();
  EXPECT_EQUAL(heard.size(), 1u);
}

TEST(spin, a_gap_within_a_frame_ends_it) {
  Listener board;
  const Bytes first = board.number(1);
  board.line.send(Bytes(first.begin(), first.begin() + 6));
  for (int ms = 0; ms < 300; ++ms) ++board.line.now_ms, board.node.spinOnce();
  board.line.send(board.number(2));
  board.node.spinOnce();
  EXPECT_EQUAL(heard.size(), 1u);
  EXPECT_EQUAL(heard[0], 2);
  EXPECT_EQUAL(board.node.dropped(), 1);
}

TEST(spin, a_frame_inside_a_broken_one_is_found) {
  Listener board;
  const Bytes whole = board.number(3);
  board.line.send(Bytes({0xff, 0xfe, 0x40, 0x00, 0xbf}) + whole + Bytes(80, 0x11));
  board.node.spinOnce();
  EXPECT_EQUAL(heard.size(), 1u);
  EXPECT_EQUAL(heard[0], 3);
}

TEST(spin, a_slow_line_of_9600_baud_brings_280_bytes) {
  Board<> board;
  static size_t length;
  length = 0;
  ros::Subscriber<std_msgs::String> texts("texts", [](const std_msgs::String& message) { length = strlen(message.data); });
  board.node.subscribe(texts);
  board.meet();
  board.line.sendSlowly(frame(texts.id_, Payload().text(std::string(276, 'x'))), 1);
  for (int i = 0; i < 40; ++i) board.line.now_ms += 10, board.node.spinOnce();
  EXPECT_EQUAL(length, 276u);
}

TEST(spin, a_loop_that_sleeps_gets_its_frames_too) {
  Listener board;
  for (int i = 0; i < 5; ++i) {
    const Bytes whole = board.number(i);
    board.line.send(Bytes(whole.begin(), whole.begin() + 4));
    board.line.now_ms += 1000;
    board.node.spinOnce();
    board.line.send(Bytes(whole.begin() + 4, whole.end()));
    board.line.now_ms += 1000;
    board.node.spinOnce();
  }
  EXPECT_EQUAL(heard.size(), 5u);
}

// A line on which a byte is always there: reading one takes the board as long as the line.
class BusyHardware : public PlainHardware {
 public:
  int read() {
    if (++reads % 10 == 0) ++line.now_ms;
    return traffic.empty() ? line.read() : traffic[at++ % traffic.size()];
  }
  Bytes traffic;
  size_t at = 0;
  unsigned reads = 0;
};

TEST(spin, a_line_that_never_pauses_ends_it_after_the_limit) {
  Board<BusyHardware> board;
  board.meet();
  const Bytes kinds[] = {frame(4711, Bytes(20)), Bytes(3, 0x55), {0xff, 0x00}, Bytes(1, 0xff), frame(10, Bytes(8, 1)),
                         {0xff, 0xfe, 0x10, 0x00, 0xef}};
  for (const Bytes& traffic : kinds) {
    board.node.getHardware()->traffic = traffic;
    unsigned long began_ms = board.line.now_ms;
    EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_TIMEOUT);
    EXPECT(board.line.now_ms - began_ms >= 1000 && board.line.now_ms - began_ms < 1100);
    board.node.setSpinTimeout(50);
    began_ms = board.line.now_ms;
    EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_TIMEOUT);
    EXPECT(board.line.now_ms - began_ms >= 50 && board.line.now_ms - began_ms < 120);
    board.node.setSpinTimeout(0);
  }
  // Meanwhile, the node has sent its requests for the time.
  EXPECT(board.line.take(10).size() >= 2);
}

TEST(spin, before_initNode_it_does_nothing) {
  Board<> board;
  board.line.send(frame(0));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_OK);
  EXPECT_EQUAL(board.line.take(0).size(), 0u);
}
