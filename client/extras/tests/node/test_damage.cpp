#include <ros.h>
#include <std_msgs/Int16.h>
#include <std_msgs/String.h>
#include <std_msgs/UInt8MultiArray.h>

#include "scripted_hardware.h"

static int numbers_heard, texts_heard, arrays_heard;

struct Target : Board<PlainHardware, 280> {
  ros::Subscriber<std_msgs::Int16> numbers;
  ros::Subscriber<std_msgs::String> texts;
  ros::Subscriber<std_msgs::UInt8MultiArray> arrays;
  Target()
      : numbers("numbers", [](const std_msgs::Int16&) { ++numbers_heard; }),
        texts("texts", [](const std_msgs::String&) { ++texts_heard; }),
        arrays("arrays", [](const std_msgs::UInt8MultiArray&) { ++arrays_heard; }) {
    numbers_heard = texts_heard = arrays_heard = 0;
    node.subscribe(numbers);
    node.subscribe(texts);
    node.subscribe(arrays);
    meet();
  }
  // Sends bytes that must be dropped, then a frame that must not.
  void dropped(const Bytes& bytes, int count = 0) {
    const int before = node.dropped(), heard = numbers_heard;
    line.send(bytes + frame(numbers.id_, Payload().u16(1)));
    for (int ms = 0; ms < 400; ++ms) ++line.now_ms, node.spinOnce();
    EXPECT_EQUAL(numbers_heard, heard + 1);
    if (count) EXPECT_EQUAL(node.dropped() - before, count);
    EXPECT(node.dropped() > before);
  }
};

TEST(damage, unknown_ids_are_dropped_and_counted) {
  Target target;
  const uint16_t ids[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 99, 104, 125, 250, 65535};
  for (uint16_t id : ids) {
    target.dropped(frame(id), 1);
    target.dropped(frame(id, Bytes(50)), 1);
  }
}

TEST(damage, wrong_lengths) {
  Target target;
  // Strings and arrays that are longer than their frame: by one up to the largest number of 32 bits.
  const uint32_t lengths[] = {1, 2, 100, 255, 65535, 65536, 0x7fffffff, 0x80000000, 0xfffffffb, 0xffffffff};
  for (uint32_t length : lengths) {
    target.dropped(frame(target.texts.id_, Payload().u32(length)));
    target.dropped(frame(target.arrays.id_, Payload().u32(0).u32(0).u32(length)));
    target.dropped(frame(target.arrays.id_, Payload().u32(length).u32(0).u32(0)));
  }
  target.dropped(frame(target.texts.id_, Payload().text("one byte too many").u8(0)));
  EXPECT_EQUAL(texts_heard, 0);
  EXPECT_EQUAL(arrays_heard, 0);
}

TEST(damage, empty_and_short_bodies) {
  Target target;
  target.dropped(frame(target.numbers.id_));
  target.dropped(frame(target.numbers.id_, Bytes(1)));
  target.dropped(frame(target.texts.id_));
  target.dropped(frame(target.texts.id_, Bytes(3)));
  target.dropped(frame(target.arrays.id_));
  EXPECT_EQUAL(numbers_heard, 4 + 1);
}

TEST(damage, oversized_frames) {
  Target target;
  target.dropped(frame(target.texts.id_, Payload().text(std::string(277, 'x'))));
  target.dropped(frame(target.texts.id_, Payload().text(std::string(65500, 'x'))));
  EXPECT_EQUAL(texts_heard, 0);
  target.line.send(frame(target.texts.id_, Payload().text(std::string(276, 'x'))));
  target.node.spinOnce();
  EXPECT_EQUAL(texts_heard, 1);
}

TEST(damage, any_one_bit_flipped) {
  Target target;
  const Bytes whole = frame(target.texts.id_, Payload().text("a text with \xff and \xff\xfe"));
  for (size_t bit = 0; bit < whole.size() * 8; ++bit) {
    Bytes damaged = whole;
    damaged[bit / 8] = static_cast<uint8_t>(damaged[bit / 8] ^ 1 << bit % 8);
    const int heard = numbers_heard;
    target.line.send(damaged);
    for (int ms = 0; ms < 300; ++ms) ++target.line.now_ms, target.node.spinOnce();
    target.line.send(frame(target.numbers.id_, Payload().u16(1)));
    for (int ms = 0; ms < 300; ++ms) ++target.line.now_ms, target.node.spinOnce();
    EXPECT_EQUAL(numbers_heard, heard + 1);
    target.line.take();
    target.line.send(Board<>::time(1700000000));
  }
  EXPECT_EQUAL(texts_heard, 0);
}

TEST(damage, every_byte_lost_or_doubled) {
  Target target;
  const Bytes whole = frame(target.texts.id_, Payload().text("a text"));
  for (size_t i = 0; i < 2 * whole.size(); ++i) {
    Bytes damaged = whole;
    const long at = static_cast<long>(i / 2);
    if (i % 2) damaged.erase(damaged.begin() + at);
    if (i % 2 == 0) damaged.insert(damaged.begin() + at, damaged[static_cast<size_t>(at)]);
    const int heard = numbers_heard;
    target.line.send(damaged + frame(target.numbers.id_, Payload().u16(1)));
    for (int ms = 0; ms < 600; ++ms) ++target.line.now_ms, target.node.spinOnce();
    // The next frame may first seem to be the rest of the damaged one.
    EXPECT_EQUAL(numbers_heard, heard + 1);
    target.line.take();
    target.line.send(Board<>::time(1700000000));
  }
}

TEST(damage, boot_noise_before_the_first_frame) {
  Board<> board;
  board.node.initNode();
  board.node.spinOnce();
  Bytes noise;
  for (int i = 0; i < 5000; ++i) noise.push_back(static_cast<uint8_t>(i * 131 >> 3));
  board.line.send(noise + frame(0));
  int result = ros::SPIN_OK;
  for (int ms = 0; ms < 1000 && result != ros::SPIN_ERR; ++ms) ++board.line.now_ms, result = board.node.spinOnce();
  EXPECT_EQUAL(result, ros::SPIN_ERR);
}

TEST(damage, nothing_but_syncs) {
  Target target;
  target.dropped(Bytes(1000, 0xff), 1000);
}
