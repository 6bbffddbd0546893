#include <library_tests/Everything.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/String.h>
#include <tf/tfMessage.h>

#include <memory>

#include "bytes.h"
#include "expect.h"

TEST(standalone, a_message_is_written_to_any_buffer_and_read_again) {
  nav_msgs::Odometry odometry, back;
  odometry.header.frame_id = "odom";
  odometry.child_frame_id = "base";
  odometry.pose.pose.position.x = 1.5;
  for (int i = 0; i < 36; ++i) odometry.twist.covariance[i] = i / 7.0;
  const size_t length = odometry.serializedLength();
  EXPECT_EQUAL(length, 12u + 8 + 8 + 85 * 8);
  std::unique_ptr<uint8_t[]> buffer(new uint8_t[length]);
  EXPECT_EQUAL(odometry.serialize(buffer.get()), static_cast<int>(length));
  EXPECT_EQUAL(odometry.serialize(buffer.get(), length), static_cast<int>(length));
  EXPECT_EQUAL(odometry.serialize(buffer.get(), length - 1), -1);
  EXPECT_EQUAL(back.deserialize(buffer.get(), length), static_cast<int>(length));
  EXPECT_EQUAL(std::string(back.header.frame_id), "odom");
  EXPECT_EQUAL(back.twist.covariance[35], 5.0);
  EXPECT_EQUAL(std::string(nav_msgs::Odometry::getType()), "nav_msgs/Odometry");
  EXPECT_EQUAL(std::string(odometry.getMD5()), "cd5e73d190d741a2f92e81eda573aca7");
}

TEST(standalone, cut_off_bytes_are_no_message) {
  sensor_msgs::JointState state;
  char* names[] = {const_cast<char*>("left"), const_cast<char*>("right")};
  double positions[] = {1, 2};
  state.name = names;
  state.position = positions;
  state.name_length = state.position_length = 2;
  Bytes whole(state.serializedLength());
  EXPECT_EQUAL(state.serialize(&whole[0]), static_cast<int>(whole.size()));
  for (size_t length = 0; length < whole.size(); ++length) {
    // The buffer has exactly the needed size, so that an access after its end is detected.
    std::unique_ptr<uint8_t[]> buffer(new uint8_t[length + 64]);
    memcpy(buffer.get(), whole.data(), length);
    sensor_msgs::JointState back;
    EXPECT_EQUAL(back.deserialize(buffer.get(), length, length + 64), -1);
  }
  std::unique_ptr<uint8_t[]> buffer(new uint8_t[whole.size() + 64]);
  memcpy(buffer.get(), whole.data(), whole.size());
  sensor_msgs::JointState back;
  // Without room for its pointers, the message is refused.
  EXPECT_EQUAL(back.deserialize(buffer.get(), whole.size()), -1);
  memcpy(buffer.get(), whole.data(), whole.size());
  EXPECT_EQUAL(back.deserialize(buffer.get(), whole.size(), whole.size() + 64), static_cast<int>(whole.size()));
  EXPECT_EQUAL(std::string(back.name[1]), "right");
  EXPECT_EQUAL(static_cast<double>(back.position[1]), 2.0);
}

TEST(standalone, arrays_of_trusted_bytes_are_on_the_heap) {
  tf::tfMessage message, back;
  geometry_msgs::TransformStamped transforms[3];
  for (int i = 0; i < 3; ++i) transforms[i].child_frame_id = "child";
  message.transforms = transforms;
  message.transforms_length = 3;
  Bytes bytes(message.serializedLength());
  message.serialize(&bytes[0]);
  for (int i = 0; i < 3; ++i) {
    Bytes copy = bytes;
    EXPECT_EQUAL(back.deserialize(&copy[0]), static_cast<int>(bytes.size()));
    EXPECT_EQUAL(back.transforms_length, 3u);
    EXPECT_EQUAL(std::string(back.transforms[2].child_frame_id), "child");
  }
  free(back.transforms);
}

TEST(standalone, all_sixty_four_bits_at_any_address) {
  library_tests::Everything message;
  int64_t larges[] = {INT64_MIN, -1, INT64_MAX};
  message.larges = larges;
  message.larges_length = 3;
  message.large = INT64_MIN + 1;
  const size_t length = message.serializedLength();
  for (size_t shift = 0; shift < 9; ++shift) {
    std::unique_ptr<uint8_t[]> buffer(new uint8_t[shift + length + 256]);
    EXPECT_EQUAL(message.serialize(buffer.get() + shift), static_cast<int>(length));
    library_tests::Everything back;
    EXPECT_EQUAL(back.deserialize(buffer.get() + shift, length, length + 256), static_cast<int>(length));
    EXPECT_EQUAL(back.large, INT64_MIN + 1);
    EXPECT(back.larges[0] == INT64_MIN && back.larges[1] == -1 && back.larges[2] == INT64_MAX);
  }
}

TEST(standalone, float_arrays_of_sketches_for_small_boards) {
  sensor_msgs::JointState state;
  double positions[] = {1.5, -2.5};
  state.position = positions;
  state.position_length = 2;
  state.position[1] += 1;
  EXPECT_EQUAL(positions[1], -1.5);
  state.position[0] = state.position[1];
  EXPECT_EQUAL(positions[0], -1.5);
  EXPECT_EQUAL(static_cast<double>(*state.position), -1.5);
  EXPECT(static_cast<bool>(state.position));
  EXPECT(!static_cast<bool>(state.velocity));
}
