#include <ros.h>

#include "scripted_hardware.h"

static long since(const ros::Time& time, uint32_t sec) {
  return static_cast<long>(static_cast<int32_t>(time.sec - sec)) * 1000 + static_cast<long>(time.nsec / 1000000);
}

TEST(time_sync, before_an_answer_it_is_the_time_since_the_start) {
  Board<> board;
  board.node.initNode();
  board.line.now_ms = 12345;
  EXPECT_EQUAL(board.node.now().sec, 12u);
  EXPECT_EQUAL(board.node.now().nsec, 345000000u);
}

TEST(time_sync, half_the_round_trip_belongs_to_the_answer) {
  Board<> board;
  board.node.initNode();
  board.node.spinOnce();
  EXPECT_EQUAL(board.line.take(10).size(), 1u);
  board.line.now_ms += 80;
  board.line.send(Board<>::time(1700000000, 250000000));
  board.node.spinOnce();
  EXPECT_EQUAL(since(board.node.now(), 1700000000), 250 + 40);
  board.line.now_ms += 1710;
  EXPECT_EQUAL(since(board.node.now(), 1700000000), 2000);
}

TEST(time_sync, an_answer_without_a_request_is_not_adjusted) {
  Board<> board;
  board.meet(1700000000);
  board.line.now_ms += 700;
  board.line.send(Board<>::time(1700000500));
  board.node.spinOnce();
  EXPECT_EQUAL(since(board.node.now(), 1700000500), 0);
}

TEST(time_sync, days_may_pass_between_two_calls_of_now) {
  Board<> board;
  board.meet(1700000000);
  board.line.now_ms += 40UL * 86400 * 1000 + 250;
  EXPECT_EQUAL(board.node.now().sec, 1700000000u + 40 * 86400);
  EXPECT_EQUAL(board.node.now().nsec, 250000000u);
}

TEST(time_sync, nanoseconds_are_kept_and_carried) {
  Board<> board;
  board.meet();
  board.line.send(Board<>::time(1700000000, 999999999));
  board.node.spinOnce();
  board.line.now_ms += 1;
  const ros::Time now = board.node.now();
  EXPECT_EQUAL(now.sec, 1700000001u);
  EXPECT_EQUAL(now.nsec, 999999u);
}

TEST(time_sync, it_never_goes_back_when_answers_are_late) {
  Board<> board;
  board.node.initNode();
  unsigned seed = 7;
  ros::Time last;
  unsigned long host_ms = 0;
  board.line.on_frame = [&](const Frame& got) {
    if (got.id != 10) return;
    seed = seed * 1103515245u + 12345u;
    const unsigned long late_ms = seed / 65536 % 300;
    host_ms = board.line.now_ms + late_ms / 3;
    const Bytes bytes =
        Board<>::time(static_cast<uint32_t>(1700000000 + host_ms / 1000), static_cast<uint32_t>(host_ms % 1000 * 1000000));
    for (size_t i = 0; i < bytes.size(); ++i) {
      const Line::Arrival arrival = {board.line.now_ms + late_ms, bytes[i]};
      board.line.arriving.push_back(arrival);
    }
  };
  for (int ms = 0; ms < 120000; ++ms) {
    ++board.line.now_ms;
    board.node.spinOnce();
    const ros::Time now = board.node.now();
    EXPECT(now >= last);
    EXPECT(now.nsec < 1000000000u);
    last = now;
  }
  const long error_ms = since(last, 1700000000) - static_cast<long>(board.line.now_ms);
  EXPECT(error_ms > -150 && error_ms < 200);
}

TEST(time_sync, it_stops_instead_of_going_back_a_little) {
  Board<> board;
  board.meet(1700000100);
  EXPECT_EQUAL(since(board.node.now(), 1700000100), 0);
  board.line.send(Board<>::time(1700000097));
  board.node.spinOnce();
  EXPECT_EQUAL(since(board.node.now(), 1700000100), 0);
  board.line.now_ms += 2000;
  EXPECT_EQUAL(since(board.node.now(), 1700000100), 0);
  board.line.now_ms += 2000;
  EXPECT_EQUAL(since(board.node.now(), 1700000100), 1000);
}

TEST(time_sync, a_host_whose_clock_was_set_back_is_followed) {
  Board<> board;
  board.meet(1700000100);
  EXPECT_EQUAL(since(board.node.now(), 1700000100), 0);
  board.line.send(Board<>::time(1700000080));
  board.node.spinOnce();
  EXPECT_EQUAL(since(board.node.now(), 1700000080), 0);
}

TEST(time_sync, setNow_accepts_any_time) {
  Board<> board;
  board.meet(1700000100);
  board.node.setNow(ros::Time(5, 6));
  EXPECT_EQUAL(board.node.now().sec, 5u);
  EXPECT_EQUAL(board.node.now().nsec, 6u);
  board.line.now_ms += 1000;
  EXPECT_EQUAL(board.node.now().sec, 6u);
}

TEST(time_sync, answers_of_a_wrong_length_are_dropped) {
  Board<> board;
  board.meet(1700000000);
  const uint16_t dropped = board.node.dropped();
  board.line.send(frame(10) + frame(10, Bytes(7)) + frame(10, Bytes(9)) + frame(10, Bytes(300)));
  board.node.spinOnce();
  EXPECT_EQUAL(board.node.dropped() - dropped, 4);
  EXPECT_EQUAL(since(board.node.now(), 1700000000), 0);
}

TEST(time_sync, invalid_nanoseconds_do_no_harm) {
  Board<> board;
  board.meet(1700000000);
  board.line.send(Board<>::time(1700000001, 0xffffffff));
  board.node.spinOnce();
  EXPECT(board.node.now().nsec < 1000000000u);
}

TEST(time_sync, time_and_duration_calculate) {
  const ros::Time early(100, 900000000), late(103, 100000000);
  const ros::Duration span = late - early;
  EXPECT_EQUAL(span.sec, 2);
  EXPECT_EQUAL(span.nsec, 200000000);
  EXPECT((early - late) == ros::Duration(-3, 800000000));
  EXPECT((early + span) == late);
  EXPECT((late - span) == early);
  EXPECT((late + (early - late)) == early);
  EXPECT((late - (early - late)).sec == 105);
  EXPECT(ros::Duration(0.5) * 3 == ros::Duration(1, 500000000));
  EXPECT(-ros::Duration(1, 1) == ros::Duration(-2, 999999999));
  EXPECT(ros::Duration(-0.25) == ros::Duration(-1, 750000000));
  EXPECT(ros::Time(1, 2500000000UL) == ros::Time(3, 500000000));
  EXPECT(early < late && late > early && early <= early && late >= late && early != late);
  EXPECT(ros::Time().fromSec(1.25) == ros::Time(1, 250000000));
  EXPECT(ros::Time(7, 8).toNsec() == 7000000008ULL);
  EXPECT(ros::Time().fromNSec(7000000008ULL) == ros::Time(7, 8));
  EXPECT_EQUAL(ros::Time(1, 500000000).toSec(), 1.5);
  EXPECT_EQUAL(ros::Duration(-1, 500000000).toSec(), -0.5);
}
