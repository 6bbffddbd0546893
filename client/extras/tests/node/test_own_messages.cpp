// Message classes of other generators: with a base class that has virtual functions, and without one.
#include "ros/subscriber.h"

#include <ros.h>
#include <std_msgs/Int16.h>
#include <std_msgs/String.h>

#include "scripted_hardware.h"

// A class with only the functions, without a base class.
class Pair {
 public:
  uint8_t left = 0, right = 0;

  int serialize(unsigned char* bytes) const {
    bytes[0] = left;
    bytes[1] = right;
    return 2;
  }
  int deserialize(unsigned char* bytes) {
    left = bytes[0];
    right = bytes[1];
    return 2;
  }
  const char* getType() { return "own/Pair"; }
  const char* getMD5() { return "0123456789abcdef0123456789abcdef"; }
};

class VirtualPair : public ros::Msg {
 public:
  Pair pair;

  int serialize(unsigned char* bytes) const override { return pair.serialize(bytes); }
  int deserialize(unsigned char* bytes) override { return pair.deserialize(bytes); }
  const char* getType() override { return "own/VirtualPair"; }
  const char* getMD5() override { return "0123456789abcdef0123456789abcdef"; }
};

static int sum;
static void add(const Pair& pair) { sum = pair.left + pair.right; }
static void addVirtual(const VirtualPair& message) { add(message.pair); }
struct Adder {
  int last = 0;
  void add(const Pair& pair) { last = pair.left + pair.right; }
};

TEST(own_messages, a_callback_runs_for_bytes_without_a_node) {
  unsigned char bytes[] = {3, 4};
  ros::Subscriber<Pair> pairs("pairs", &add);
  pairs.callback(bytes);
  EXPECT_EQUAL(sum, 7);
  Adder adder;
  ros::Subscriber<Pair, Adder> members("pairs", &Adder::add, &adder);
  members.callback(bytes);
  EXPECT_EQUAL(adder.last, 7);
}

TEST(own_messages, a_callback_runs_for_the_bytes_of_a_generated_message) {
  static std::string heard;
  ros::Subscriber<std_msgs::String> texts("texts", [](const std_msgs::String& message) { heard = message.data; });
  Bytes bytes = Payload().text("hello");
  texts.callback(bytes.data());
  EXPECT_EQUAL(heard, "hello");
}

TEST(own_messages, they_are_received_and_sent) {
  Board<> board;
  Pair pair;
  VirtualPair virtual_pair;
  ros::Publisher out("out", &pair), virtual_out("virtual_out", &virtual_pair);
  ros::Subscriber<Pair> in("in", &add);
  ros::Subscriber<VirtualPair> virtual_in("virtual_in", &addVirtual);
  board.node.advertise(out);
  board.node.advertise(virtual_out);
  board.node.subscribe(in);
  board.node.subscribe(virtual_in);
  board.meet();
  board.line.send(frame(0));
  board.node.spinOnce();
  const std::vector<TopicInfo> infos = board.announced();
  EXPECT_EQUAL(infos.size(), 4u);
  const char* const types[] = {"own/Pair", "own/VirtualPair", "own/Pair", "own/VirtualPair"};
  for (size_t i = 0; i < 4; ++i) EXPECT_EQUAL(infos[i].type, types[i]);
  pair.left = virtual_pair.pair.right = 9;
  EXPECT_EQUAL(out.publish(&pair), 10);
  EXPECT_EQUAL(virtual_out.publish(&virtual_pair), 10);
  EXPECT_EQUAL(out.publish(&virtual_pair), -1);
  EXPECT(board.line.take(out.id_)[0].payload == Bytes({9, 0}));
  board.line.send(frame(in.id_, Bytes({1, 2})));
  board.node.spinOnce();
  EXPECT_EQUAL(sum, 3);
  board.line.send(frame(virtual_in.id_, Bytes({5, 6})));
  board.node.spinOnce();
  EXPECT_EQUAL(sum, 11);
  // These messages have a wrong length.
  board.line.send(frame(in.id_, Bytes(3)) + frame(in.id_, Bytes(1)));
  board.node.spinOnce();
  EXPECT_EQUAL(sum, 11);
}
