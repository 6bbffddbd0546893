#include <ros.h>
#include <std_msgs/String.h>

#include "scripted_hardware.h"

static const unsigned long PERIOD_MS = 2500;

TEST(silence, the_time_is_requested_about_every_two_seconds) {
  Board<> board;
  board.meet();
  unsigned long last_ms = board.line.now_ms;
  int asked = 0;
  board.line.on_frame = [&](const Frame& got) {
    EXPECT_EQUAL(got.id, 10);
    EXPECT(board.line.now_ms - last_ms <= PERIOD_MS);
    EXPECT(board.line.now_ms - last_ms >= 2000);
    last_ms = board.line.now_ms;
    ++asked;
    board.line.send(Board<>::time(1700000000));
  };
  for (int ms = 0; ms < 60000; ++ms) {
    ++board.line.now_ms;
    EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_OK);
    EXPECT(board.node.connected());
  }
  EXPECT(asked >= 24);
}

TEST(silence, after_eleven_seconds_the_host_is_disconnected) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  board.node.advertise(chatter);
  board.meet();
  const unsigned long answered_ms = board.line.now_ms;
  while (board.node.connected()) {
    ++board.line.now_ms;
    board.node.spinOnce();
    EXPECT(board.line.now_ms - answered_ms < 12000);
  }
  EXPECT(board.line.now_ms - answered_ms >= 10500);
  board.line.take();
  text.data = "nobody hears";
  EXPECT_EQUAL(chatter.publish(&text), 0);
  EXPECT_EQUAL(board.line.take().size(), 0u);
  // The host is connected again after a request for the topics, or after an answer to a time request.
  board.line.send(frame(0));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_ERR);
  EXPECT(board.node.connected());
  EXPECT(chatter.publish(&text) > 0);
}

TEST(silence, messages_alone_do_not_count_as_a_host) {
  Board<> board;
  board.meet();
  for (int ms = 0; ms < 12000; ++ms) {
    ++board.line.now_ms;
    if (ms % 100 == 0) board.line.send(frame(4711));
    board.node.spinOnce();
  }
  EXPECT(!board.node.connected());
}

// A network whose connection can be replaced.
class NetworkHardware : public PlainHardware {
 public:
  bool relinked() {
    const bool changed = changed_;
    changed_ = false;
    return changed;
  }
  void relink() {
    ++relinks;
    changed_ = true;
  }

  int relinks = 0;

 private:
  bool changed_ = false;
};

TEST(silence, a_connection_to_a_silent_host_is_replaced_every_ten_seconds) {
  Board<NetworkHardware> board;
  board.meet();
  for (int ms = 0; ms < 35000; ++ms) {
    ++board.line.now_ms;
    board.node.spinOnce();
  }
  EXPECT_EQUAL(board.node.getHardware()->relinks, 3);
  // A sketch that blocks for longer than ten seconds gets the host's answer at its next spin: the link stays.
  board.node.initNode();
  for (int i = 0; i < 10; ++i) {
    board.line.now_ms += 20000;
    board.line.send(Board<>::time(1700000000));
    for (int spins = 0; spins < 3; ++spins) board.node.spinOnce();
  }
  EXPECT_EQUAL(board.node.getHardware()->relinks, 3);
}

TEST(silence, a_stop_disconnects_at_once) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  board.node.advertise(chatter);
  board.meet();
  board.line.send(frame(11));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_OK);
  EXPECT(!board.node.connected());
  EXPECT_EQUAL(chatter.publish(&text), 0);
  board.line.send(frame(0));
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_ERR);
  EXPECT(board.node.connected());
}

TEST(silence, a_sketch_that_sleeps_for_a_minute_still_requests_the_time) {
  Board<> board;
  board.meet();
  for (int i = 0; i < 20; ++i) {
    board.line.now_ms += 60000;
    board.node.spinOnce();
    EXPECT_EQUAL(board.line.take(10).size(), 1u);
    board.line.send(Board<>::time(1700000000));
    board.node.spinOnce();
    EXPECT(board.node.connected());
  }
}

TEST(silence, the_milliseconds_overflow_without_a_trace) {
  Board<> board;
  std_msgs::String text;
  ros::Publisher chatter("chatter", &text);
  board.node.advertise(chatter);
  board.line.now_ms = 0xffffffffUL - 5000;
  board.meet(1700000000);
  board.line.on_frame = [&](const Frame&) {};
  ros::Time last = board.node.now();
  for (unsigned long ms = 1; ms < 10000; ++ms) {
    board.line.now_ms = (0xffffffffUL - 5000 + ms) & 0xffffffffUL;
    board.node.spinOnce();
    const ros::Time now = board.node.now();
    EXPECT(now >= last);
    last = now;
  }
  EXPECT_EQUAL(last.sec, 1700000009u);
  EXPECT_EQUAL(board.line.take(10).size(), 4u);
}

TEST(silence, an_unconfigured_node_answers_a_wrong_version_once) {
  Board<> board;
  board.node.initNode();
  board.node.spinOnce();
  board.line.take();
  for (int i = 0; i < 30; ++i) board.line.now_ms += 1, board.node.spinOnce();
  board.line.send({0xff, 0x00});
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_OK);
  EXPECT_EQUAL(board.line.take(10).size(), 1u);
  // A burst of wrong versions gets one answer, even if it takes some milliseconds.
  board.line.now_ms += 100;
  board.line.sendSlowly({0xff, 0x00, 0xff, 0x00, 0xff, 0x00, 0xff, 0x01}, 1);
  for (int i = 0; i < 15; ++i) board.line.now_ms += 1, board.node.spinOnce();
  EXPECT_EQUAL(board.line.take(10).size(), 1u);
}

TEST(silence, a_configured_node_ignores_a_wrong_version) {
  Board<> board;
  board.meet();
  board.line.now_ms += 100;
  board.line.send({0xff, 0x00, 0xff, 0x00, 0xff, 0x00});
  EXPECT_EQUAL(board.node.spinOnce(), ros::SPIN_OK);
  EXPECT_EQUAL(board.line.take().size(), 0u);
}
