#include <math.h>
#include <ros.h>

#include "scripted_hardware.h"

struct Asker : Board<> {
  std::vector<std::string> asked;
  Bytes answer;
  Asker() {
    meet();
    line.silence_ms = 1;
    line.on_frame = [this](const Frame& got) {
      if (got.id != 6) return;
      Parser parser(got.payload);
      asked.push_back(parser.text());
      EXPECT(parser.atEnd());
      line.send(answer);
    };
  }
  void ints(const std::vector<int32_t>& values) {
    Payload payload;
    payload.u32(static_cast<uint32_t>(values.size()));
    for (int32_t value : values) payload.value(value);
    answer = frame(6, payload.u32(0).u32(0));
  }
  void floats(const std::vector<float>& values) {
    Payload payload;
    payload.u32(0).u32(static_cast<uint32_t>(values.size()));
    for (float value : values) payload.value(value);
    answer = frame(6, payload.u32(0));
  }
  void texts(const std::vector<std::string>& values) {
    Payload payload;
    payload.u32(0).u32(0).u32(static_cast<uint32_t>(values.size()));
    for (const std::string& value : values) payload.text(value);
    answer = frame(6, payload);
  }
  std::string warned() {
    const std::vector<Frame> logs = line.take(7);
    if (logs.empty()) return "";
    Parser parser(logs[0].payload);
    EXPECT_EQUAL(int(parser.value<uint8_t>()), 2);
    return parser.text();
  }
};

TEST(parameters, numbers) {
  Asker asker;
  int number = 0, numbers[3] = {0, 0, 0};
  asker.ints({-7});
  EXPECT(asker.node.getParam("~gain", &number));
  EXPECT_EQUAL(number, -7);
  EXPECT_EQUAL(asker.asked[0], "~gain");
  asker.ints({1, -2147483647 - 1, 2147483647});
  EXPECT(asker.node.getParam("list", numbers, 3));
  EXPECT_EQUAL(numbers[0], 1);
  EXPECT_EQUAL(numbers[1], -2147483647 - 1);
  EXPECT_EQUAL(numbers[2], 2147483647);
  float single = 0, singles[2] = {0, 0};
  asker.floats({2.5f});
  EXPECT(asker.node.getParam("kp", &single));
  EXPECT_EQUAL(single, 2.5f);
  asker.floats({-0.0f, INFINITY});
  EXPECT(asker.node.getParam("ks", singles, 2));
  EXPECT(signbit(singles[0]) && isinf(singles[1]));
  EXPECT_EQUAL(asker.warned(), "");
}

TEST(parameters, bools) {
  Asker asker;
  bool flag = false, flags[3] = {false, false, true};
  asker.ints({1});
  EXPECT(asker.node.getParam("on", &flag));
  EXPECT(flag);
  asker.ints({0, 256, 0});
  EXPECT(asker.node.getParam("flags", flags, 3));
  EXPECT(!flags[0] && flags[1] && !flags[2]);
}

TEST(parameters, texts) {
  Asker asker;
  char name[10] = "", other[10] = "";
  char* one = name;
  char* two[2] = {name, other};
  asker.texts({"robot"});
  EXPECT(asker.node.getParam("name", &one));
  EXPECT_EQUAL(std::string(name), "robot");
  asker.texts({"left", "right"});
  EXPECT(asker.node.getParam("names", two, 2));
  EXPECT_EQUAL(std::string(name), "left");
  EXPECT_EQUAL(std::string(other), "right");
  char small[4] = "???";
  asker.texts({"too long for it"});
  EXPECT(asker.node.getParam("name", small, sizeof small));
  EXPECT_EQUAL(std::string(small), "too");
  asker.texts({""});
  EXPECT(asker.node.getParam("name", small, sizeof small));
  EXPECT_EQUAL(std::string(small), "");
}

TEST(parameters, values_that_do_not_fit_change_nothing) {
  Asker asker;
  int number = 5;
  float single = 6;
  bool flag = true;
  char name[8] = "keep";
  char* one = name;
  const char* const mismatch = "Failed to get param: length mismatch";
  asker.floats({1});
  EXPECT(!asker.node.getParam("p", &number));
  EXPECT_EQUAL(asker.warned(), mismatch);
  EXPECT(!asker.node.getParam("p", &flag));
  asker.ints({1});
  EXPECT(!asker.node.getParam("p", &single));
  EXPECT(!asker.node.getParam("p", &one));
  EXPECT(!asker.node.getParam("p", name, sizeof name));
  asker.ints({1, 2});
  EXPECT(!asker.node.getParam("p", &number));
  asker.texts({"a", "b"});
  EXPECT(!asker.node.getParam("p", &one));
  EXPECT(!asker.node.getParam("p", name, sizeof name));
  EXPECT(!asker.node.getParam("p", &number));
  EXPECT(number == 5 && single == 6 && flag && std::string(name) == "keep");
}

TEST(parameters, an_empty_answer_is_no_parameter) {
  Asker asker;
  int number = 5;
  asker.ints({});
  const unsigned long began_ms = asker.line.now_ms;
  EXPECT(!asker.node.getParam("none", &number));
  EXPECT(asker.line.now_ms - began_ms < 100);
  EXPECT_EQUAL(number, 5);
}

TEST(parameters, no_answer_ends_after_the_time) {
  Asker asker;
  int number = 5;
  const unsigned long began_ms = asker.line.now_ms;
  EXPECT(!asker.node.getParam("none", &number, 1, 250));
  EXPECT(asker.line.now_ms - began_ms >= 250 && asker.line.now_ms - began_ms < 300);
  EXPECT_EQUAL(asker.warned(), "Failed to get param: timeout expired");
}

TEST(parameters, invalid_answers_do_not_end_the_wait) {
  Asker asker;
  int number = 0;
  char name[8] = "keep";
  asker.ints({3});
  const Bytes good = asker.answer;
  asker.answer = frame(6) + frame(6, Payload().u32(0xffffffff).u32(0).u32(0)) + frame(6, Payload().u32(1).u32(1)) +
                 frame(6, Payload().u32(0).u32(0x40000000).u32(0)) + frame(6, Payload().u32(0).u32(0).u32(0xffffffff)) + good;
  EXPECT(asker.node.getParam("p", &number));
  EXPECT_EQUAL(number, 3);
  asker.answer = frame(6, Payload().u32(0).u32(0).u32(1).u32(5)) + frame(6, Payload().u32(0).u32(0).u32(1).text("x").u8(0));
  EXPECT(!asker.node.getParam("p", name, sizeof name, 50));
}
