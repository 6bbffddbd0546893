// The DYNAMIXEL protocol 2.0. The packets are the examples in ROBOTIS' e-Manual of the protocol.
#include <deque>

#include "dynamixel/bus.h"
#include "dynamixel/x_series.h"
#include "expect.h"

namespace {

// A line with its own clock: each idle() takes 100 us.
struct Line {
  std::vector<Bytes> sent;
  std::deque<Bytes> answers;  // one for each request
  Bytes received;
  size_t read_bytes = 0;
  uint32_t now_us = 0xfffff000;  // wraps soon

  void write(const uint8_t* bytes, size_t size) {
    sent.push_back(Bytes(bytes, bytes + size));
    if (answers.empty()) return;
    received.insert(received.end(), answers.front().begin(), answers.front().end());
    answers.pop_front();
  }
  int read() { return read_bytes < received.size() ? received[read_bytes++] : -1; }
  uint32_t microseconds() { return now_us; }
  void idle() { now_us += 100; }
};

const Bytes PONG = {0xff, 0xff, 0xfd, 0x00, 0x01, 0x07, 0x00, 0x55, 0x00, 0x06, 0x04, 0x26, 0x65, 0x5d};
const Bytes POSITION_166 = {0xff, 0xff, 0xfd, 0x00, 0x01, 0x08, 0x00, 0x55, 0x00, 0xa6, 0x00, 0x00, 0x00, 0x8c, 0xc0};
const Bytes POSITION_OF_2 = {0xff, 0xff, 0xfd, 0x00, 0x02, 0x08, 0x00, 0x55, 0x00, 0x1f, 0x08, 0x00, 0x00, 0xba, 0xbe};
const Bytes WRITTEN = {0xff, 0xff, 0xfd, 0x00, 0x01, 0x04, 0x00, 0x55, 0x00, 0xa1, 0x0c};

Bytes status(uint8_t id, const Bytes& parameters) {
  dynamixel::PacketWriter<64> writer;
  writer.begin(id, dynamixel::STATUS);
  for (size_t i = 0; i < parameters.size(); ++i) writer.add(parameters[i]);
  EXPECT(writer.finish());
  return Bytes(writer.bytes(), writer.bytes() + writer.size());
}

}  // namespace

TEST(dynamixel, requests_are_those_of_the_manual) {
  Line line;
  dynamixel::Bus<Line> bus(line);
  line.answers = {PONG, POSITION_166, WRITTEN};
  uint16_t model = 0;
  EXPECT(bus.ping(1, model) == dynamixel::DONE);
  EXPECT_EQUAL(model, 1030);
  uint8_t bytes[4];
  EXPECT(bus.read(1, 132, bytes, 4) == dynamixel::DONE);
  EXPECT_EQUAL(dynamixel::toInt32(bytes), 166);
  EXPECT(bus.write(1, 116, 512, 4) == dynamixel::DONE);
  const uint8_t ids[] = {1, 2};
  const int32_t positions[] = {150, 170};
  EXPECT(bus.syncWrite(116, 4, ids, positions, 2) == dynamixel::DONE);
  line.answers = {WRITTEN};
  EXPECT(bus.reboot(1) == dynamixel::DONE);
  const std::vector<Bytes> wanted = {
      {0xff, 0xff, 0xfd, 0x00, 0x01, 0x03, 0x00, 0x01, 0x19, 0x4e},
      {0xff, 0xff, 0xfd, 0x00, 0x01, 0x07, 0x00, 0x02, 0x84, 0x00, 0x04, 0x00, 0x1d, 0x15},
      {0xff, 0xff, 0xfd, 0x00, 0x01, 0x09, 0x00, 0x03, 0x74, 0x00, 0x00, 0x02, 0x00, 0x00, 0xca, 0x89},
      {0xff, 0xff, 0xfd, 0x00, 0xfe, 0x11, 0x00, 0x83, 0x74, 0x00, 0x04, 0x00,
       0x01, 0x96, 0x00, 0x00, 0x00, 0x02, 0xaa, 0x00, 0x00, 0x00, 0x82, 0x87},
      {0xff, 0xff, 0xfd, 0x00, 0x01, 0x03, 0x00, 0x08, 0x2f, 0x4e}};
  EXPECT(line.sent == wanted);
}

TEST(dynamixel, reads_several_servos_at_once) {
  Line line;
  dynamixel::Bus<Line> bus(line);
  line.answers = {POSITION_166 + POSITION_OF_2};
  const uint8_t ids[] = {1, 2};
  uint8_t bytes[8];
  EXPECT(bus.syncRead(dynamixel::PRESENT_POSITION, 4, ids, bytes, 2) == dynamixel::DONE);
  EXPECT_EQUAL(dynamixel::toInt32(bytes), 166);
  EXPECT_EQUAL(dynamixel::toInt32(bytes + 4), 2079);
  const Bytes wanted = {0xff, 0xff, 0xfd, 0x00, 0xfe, 0x09, 0x00, 0x82, 0x84, 0x00, 0x04, 0x00, 0x01, 0x02, 0xce, 0xfa};
  EXPECT(line.sent[0] == wanted);
}

TEST(dynamixel, a_header_in_the_parameters_is_stuffed) {
  const Bytes parameters = {0, 0xff, 0xff, 0xff, 0xfd, 0xfd, 0xff, 0xff, 0xfd};
  const Bytes packet = status(1, parameters);
  // ff ff fd occurs twice, so two bytes are added.
  EXPECT_EQUAL(packet.size(), 7u + 1 + parameters.size() + 2 + 2);
  EXPECT_EQUAL(packet[5], packet.size() - 7);
  dynamixel::PacketReader<16> reader;
  // Noise that looks like the start of a header.
  const Bytes noise = {0xff, 0xff, 0xfd, 0x01, 0xff};
  const Bytes line = noise + packet;
  for (size_t i = 0; i < line.size(); ++i) EXPECT_EQUAL(reader.push(line[i]), i + 1 == line.size());
  EXPECT(Bytes(reader.parameters(), reader.parameters() + reader.size()) == parameters);
  EXPECT_EQUAL(reader.damaged(), 0u);
}

TEST(dynamixel, each_damaged_byte_is_detected) {
  for (size_t i = 0; i < PONG.size(); ++i) {
    Line line;
    dynamixel::Bus<Line> bus(line);
    Bytes damaged = PONG;
    damaged[i] = static_cast<uint8_t>(damaged[i] ^ 0x10);
    line.answers = {damaged, PONG};
    uint16_t model;
    const dynamixel::Result result = bus.ping(1, model);
    EXPECT(result == dynamixel::DAMAGED || result == dynamixel::NO_ANSWER);
    // The next request works.
    EXPECT(bus.ping(1, model) == dynamixel::DONE);
  }
}

TEST(dynamixel, errors_of_a_servo_are_reported) {
  Line line;
  dynamixel::Bus<Line> bus(line);
  line.answers = {status(1, {dynamixel::ACCESS_ERROR}), status(1, {dynamixel::ALERT}), status(1, {0, 1})};
  EXPECT(bus.write(1, dynamixel::OPERATING_MODE, 1, 1) == dynamixel::REFUSED);
  EXPECT_EQUAL(bus.error(), dynamixel::ACCESS_ERROR);
  // A hardware error does not make the answer wrong.
  EXPECT(bus.write(1, dynamixel::TORQUE_ENABLE, 1, 1) == dynamixel::DONE);
  EXPECT_EQUAL(bus.error(), dynamixel::ALERT);
  uint8_t bytes[4];
  EXPECT(bus.read(1, dynamixel::PRESENT_POSITION, bytes, 4) == dynamixel::DAMAGED);
}

TEST(dynamixel, silence_ends_a_request) {
  Line line;
  dynamixel::Bus<Line> bus(line, 3000);
  uint8_t bytes[8];
  const uint8_t ids[] = {1, 2};
  const uint32_t before_us = line.now_us;
  EXPECT(bus.syncRead(132, 4, ids, bytes, 2) == dynamixel::NO_ANSWER);
  EXPECT_EQUAL(line.now_us - before_us, 3000u);
  // A late answer does not belong to the next request.
  line.received = POSITION_166;
  line.answers = {POSITION_OF_2};
  EXPECT(bus.read(2, 132, bytes, 4) == dynamixel::DONE);
  EXPECT_EQUAL(dynamixel::toInt32(bytes), 2079);
  line.answers = {POSITION_166};
  EXPECT(bus.syncRead(132, 4, ids, bytes, 2) == dynamixel::NO_ANSWER);
}

TEST(dynamixel, a_line_that_never_pauses_ends_a_request) {
  struct Noise {
    uint32_t now_us = 0;
    void write(const uint8_t*, size_t) {}
    int read() {
      now_us += 10;
      return 0;
    }
    uint32_t microseconds() { return now_us; }
    void idle() {}
  } noise;
  dynamixel::Bus<Noise> bus(noise);
  uint16_t model;
  EXPECT(bus.ping(1, model) == dynamixel::DAMAGED);
  EXPECT(noise.now_us < 50000);
}

TEST(dynamixel, a_request_that_is_too_long_is_not_sent) {
  Line line;
  dynamixel::Bus<Line, 24> bus(line);
  const uint8_t ids[] = {1, 2, 3};
  const int32_t values[] = {1, 2, 3};
  EXPECT(bus.syncWrite(104, 4, ids, values, 2) == dynamixel::DONE);
  EXPECT(bus.syncWrite(104, 4, ids, values, 3) == dynamixel::TOO_LONG);
  EXPECT_EQUAL(line.sent.size(), 1u);
}

// The sanitizers check that long packets and noise stay in the reader's memory.
TEST(dynamixel, a_reader_survives_any_bytes) {
  dynamixel::PacketReader<8> reader;
  uint32_t random = 1;
  for (int i = 0; i < 200000; ++i) {
    random = random * 1664525 + 1013904223;
    const Bytes header = {0xff, 0xff, 0xfd, 0x00, 0x01, static_cast<uint8_t>(random >> 28), 0x00, 0x55};
    const size_t place = random >> 8 & 15;
    reader.push(place < header.size() ? header[place] : static_cast<uint8_t>(random >> 16));
    if (i % 16 == 0) {
      for (size_t j = 0; j < header.size(); ++j) reader.push(header[j]);
    }
  }
  EXPECT(reader.size() <= 8);
}
