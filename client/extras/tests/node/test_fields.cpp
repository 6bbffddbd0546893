#include <diagnostic_msgs/DiagnosticArray.h>
#include <library_tests/Everything.h>
#include <ros.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Bool.h>
#include <std_msgs/String.h>
#include <tf/tfMessage.h>

#include "scripted_hardware.h"

// The same message as the host writes it, and as a sketch fills it.
static Bytes everythingOnTheWire() {
  Payload payload;
  payload.u8(1).value(-0.1).value<int64_t>(-1234567890123456789LL);
  payload.u32(3).u8(1).u8(0).u8(1);
  payload.u32(3).text("one").text("").text("three");
  payload.u32(2).value(1e300).value(-2.5);
  payload.u32(1).value<int64_t>(-2);
  payload.u32(2).value<uint64_t>(0xffffffffffffffffULL).value<uint64_t>(3);
  payload.u32(1).u32(10).u32(20);
  payload.u32(1).value<int32_t>(-10).value<int32_t>(20);
  payload.u32(2).u8(1).text("left").u32(1).value(0.5).u8(2).text("right").u32(0);
  payload.u8(0).u8(1).u8(1);
  payload.text("a").text("bc");
  payload.value(1.0).value(2.0).value(3.0);
  payload.value<int64_t>(4).value<int64_t>(-5);
  payload.u8(3).text("x").u32(0).u8(4).text("").u32(2).value(7.0).value(8.0);
  payload.u32(100).u32(200);
  payload.u32(5).u8(1).u8(2).u8(3).u8(4).u8(5);
  payload.u32(2).value(1.5f).value(-1.5f);
  payload.u32(1).u16(65535);
  payload.u32(3);
  payload.u8(99);
  return payload;
}

static void check(const library_tests::Everything& m) {
  EXPECT(m.flag && m.real == -0.1 && m.large == -1234567890123456789LL);
  EXPECT(m.flags_length == 3 && m.flags[0] && !m.flags[1] && m.flags[2]);
  EXPECT(m.texts_length == 3 && !strcmp(m.texts[0], "one") && !strcmp(m.texts[1], "") && !strcmp(m.texts[2], "three"));
  EXPECT(m.reals_length == 2 && m.reals[0] == 1e300 && m.reals[1] == -2.5);
  EXPECT(m.larges_length == 1 && m.larges[0] == -2);
  EXPECT(m.unsigned_larges_length == 2 && m.unsigned_larges[0] == 0xffffffffffffffffULL && m.unsigned_larges[1] == 3);
  EXPECT(m.times_length == 1 && m.times[0] == ros::Time(10, 20));
  EXPECT(m.durations_length == 1 && m.durations[0] == ros::Duration(-10, 20));
  EXPECT(m.parts_length == 2 && m.parts[0].kind == 1 && !strcmp(m.parts[0].name, "left") && m.parts[0].values[0] == 0.5);
  EXPECT(m.parts[1].kind == 2 && !strcmp(m.parts[1].name, "right") && m.parts[1].values_length == 0);
  EXPECT(!m.three_flags[0] && m.three_flags[1] && m.three_flags[2]);
  EXPECT(!strcmp(m.two_texts[0], "a") && !strcmp(m.two_texts[1], "bc"));
  EXPECT(m.three_reals[0] == 1 && m.three_reals[1] == 2 && m.three_reals[2] == 3);
  EXPECT(m.two_larges[0] == 4 && m.two_larges[1] == -5);
  EXPECT(m.two_parts[1].kind == 4 && m.two_parts[1].values_length == 2 && m.two_parts[1].values[1] == 8);
  EXPECT(m.stamp == ros::Time(100, 200));
  EXPECT(m.octets_length == 5 && m.octets[0] == 1 && m.octets[4] == 5);
  EXPECT(m.singles_length == 2 && m.singles[0] == 1.5f && m.singles[1] == -1.5f);
  EXPECT(m.words_length == 1 && m.words[0] == 65535);
  EXPECT(m.nothings_length == 3 && m.last == 99);
}

struct Echo : Board<> {
  library_tests::Everything sent;
  ros::Publisher out;
  ros::Subscriber<library_tests::Everything, Echo> in;
  int heard = 0;
  Echo() : out("out", &sent), in("in", &Echo::hear, this) {
    node.advertise(out);
    node.subscribe(in);
    meet();
  }
  void hear(const library_tests::Everything& message) {
    check(message);
    ++heard;
    EXPECT(out.publish(&message) > 0);
  }
};

TEST(fields, every_kind_is_received_and_sent_again) {
  Echo echo;
  const Bytes payload = everythingOnTheWire();
  for (int i = 0; i < 10; ++i) {
    echo.line.send(frame(echo.in.id_, payload));
    echo.node.spinOnce();
    const std::vector<Frame> frames = echo.line.take(echo.out.id_);
    EXPECT_EQUAL(frames.size(), 1u);
    EXPECT_EQUAL(frames[0].payload, payload);
  }
  EXPECT_EQUAL(echo.heard, 10);
}

TEST(fields, at_every_place_in_the_buffer) {
  Echo echo;
  const Bytes payload = everythingOnTheWire();
  // The frame before it shifts its address, so that all remainders occur on processors that align their words.
  for (size_t shift = 0; shift < 16; ++shift) {
    echo.line.send(frame(4711, Bytes(shift)) + frame(echo.in.id_, payload));
    echo.node.spinOnce();
    EXPECT_EQUAL(echo.line.take(echo.out.id_).at(0).payload, payload);
  }
}

TEST(fields, cut_off_anywhere_it_is_dropped) {
  Echo echo;
  const Bytes payload = everythingOnTheWire();
  for (size_t length = 0; length < payload.size(); ++length) {
    echo.line.send(frame(echo.in.id_, Bytes(payload.begin(), payload.begin() + static_cast<long>(length))));
    echo.node.spinOnce();
  }
  Bytes longer = payload;
  longer.push_back(0);
  echo.line.send(frame(echo.in.id_, longer));
  echo.node.spinOnce();
  EXPECT_EQUAL(echo.heard, 0);
  EXPECT_EQUAL(static_cast<size_t>(echo.node.dropped()), payload.size() + 1);
}

TEST(fields, a_buffer_too_small_for_its_arrays_drops_the_message) {
  Board<PlainHardware, 90> board;
  static int heard;
  heard = 0;
  ros::Subscriber<sensor_msgs::JointState> states("states", [](const sensor_msgs::JointState& state) {
    for (uint32_t i = 0; i < state.name_length; ++i) EXPECT_EQUAL(std::string(state.name[i]), "j");
    heard = static_cast<int>(state.name_length);
  });
  board.node.subscribe(states);
  board.meet();
  int most = 0;
  for (uint32_t names = 1; names < 12; ++names) {
    Payload payload;
    payload.u32(0).u32(0).u32(0).text("").u32(names);
    for (uint32_t i = 0; i < names; ++i) payload.text("j");
    payload.u32(0).u32(0).u32(0);
    heard = 0;
    board.line.send(frame(states.id_, payload));
    board.node.spinOnce();
    EXPECT(heard == 0 || heard == static_cast<int>(names));
    if (heard) most = heard;
  }
  EXPECT(most > 0 && most < 11);
}

TEST(fields, messages_within_messages_within_arrays) {
  Board<> board;
  static size_t values;
  values = 0;
  ros::Subscriber<diagnostic_msgs::DiagnosticArray> diagnostics("d", [](const diagnostic_msgs::DiagnosticArray& message) {
    EXPECT_EQUAL(message.status_length, 2u);
    for (uint32_t i = 0; i < message.status_length; ++i) {
      EXPECT_EQUAL(std::string(message.status[i].name), "motor");
      for (uint32_t j = 0; j < message.status[i].values_length; ++j, ++values) {
        EXPECT_EQUAL(std::string(message.status[i].values[j].key), "k");
        EXPECT_EQUAL(std::string(message.status[i].values[j].value), "v");
      }
    }
  });
  board.node.subscribe(diagnostics);
  board.meet();
  Payload payload;
  payload.u32(0).u32(0).u32(0).text("").u32(2);
  for (int i = 0; i < 2; ++i) payload.u8(0).text("motor").text("ok").text("id").u32(2).text("k").text("v").text("k").text("v");
  board.line.send(frame(diagnostics.id_, payload));
  board.node.spinOnce();
  EXPECT_EQUAL(values, 4u);
}

TEST(fields, a_text_with_a_nul_ends_there) {
  Board<> board;
  static std::string got;
  ros::Subscriber<std_msgs::String> texts("texts", [](const std_msgs::String& message) { got = message.data; });
  board.node.subscribe(texts);
  board.meet();
  board.line.send(frame(texts.id_, Payload().text(std::string("be\0hind", 7))));
  board.node.spinOnce();
  EXPECT_EQUAL(got, "be");
}

TEST(fields, a_bool_is_zero_or_one_after_any_byte) {
  Board<> board;
  static int seen;
  seen = 0;
  ros::Subscriber<std_msgs::Bool> flags("flags", [](const std_msgs::Bool& message) { seen += message.data ? 1 : 100; });
  board.node.subscribe(flags);
  board.meet();
  board.line.send(frame(flags.id_, Payload().u8(2)) + frame(flags.id_, Payload().u8(255)) + frame(flags.id_, Payload().u8(0)));
  board.node.spinOnce();
  EXPECT_EQUAL(seen, 102);
}

TEST(fields, a_length_without_elements_is_sent_as_an_empty_array) {
  struct Robot : Board<> {
    sensor_msgs::JointState joints;
    ros::Publisher out;
    Robot() : out("joints", &joints) {
      node.advertise(out);
      meet();
    }
  } robot;
  robot.joints.name_length = robot.joints.position_length = robot.joints.effort_length = 2;
  EXPECT(robot.out.publish(&robot.joints) > 0);
  const std::vector<Frame> sent = robot.line.take();
  EXPECT_EQUAL(sent.size(), 1u);
  const Bytes wanted = Payload().u32(0).u32(0).u32(0).text("").u32(0).u32(0).u32(0).u32(0);
  EXPECT(sent[0].payload == wanted);
}
