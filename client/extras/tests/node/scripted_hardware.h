// A Hardware whose line, clock and transmitter a test controls, and the host at the other end of the line.
#ifndef SCRIPTED_HARDWARE_H_
#define SCRIPTED_HARDWARE_H_

#include <ros.h>

#include <deque>
#include <functional>
#include <vector>

#include "bytes.h"
#include "expect.h"

// The other end of the line, shared by the Hardware classes below.
struct Line {
  struct Arrival {
    unsigned long at_ms;
    uint8_t byte;
  };

  unsigned long now_ms = 0;
  // The time that passes with each check of a silent line, for loops that wait.
  unsigned long silence_ms = 0;
  unsigned long looks = 0;
  int begun = 0;
  std::deque<Arrival> arriving;
  Bytes written;
  std::vector<Frame> frames;
  // Bytes that are not a frame; the library never writes such bytes.
  size_t noise = 0;
  std::function<void(const Frame&)> on_frame;

  void send(const Bytes& bytes) { sendSlowly(bytes, 0); }
  void sendSlowly(const Bytes& bytes, unsigned long ms_a_byte) {
    unsigned long at_ms = now_ms;
    if (!arriving.empty() && arriving.back().at_ms > at_ms) at_ms = arriving.back().at_ms;
    for (size_t i = 0; i < bytes.size(); ++i) {
      const Arrival arrival = {at_ms += ms_a_byte, bytes[i]};
      arriving.push_back(arrival);
    }
  }

  int read() {
    if (!arriving.empty() && arriving.front().at_ms <= now_ms) {
      const uint8_t byte = arriving.front().byte;
      arriving.pop_front();
      return byte;
    }
    now_ms += silence_ms;
    return -1;
  }
  // The time also passes in a loop that only reads the clock.
  unsigned long time() {
    if (silence_ms && ++looks % 50 == 0) ++now_ms;
    return now_ms;
  }
  void write(const uint8_t* bytes, int count) {
    EXPECT(count > 0);
    written.insert(written.end(), bytes, bytes + count);
    parse();
  }
  void parse() {
    for (;;) {
      while (!written.empty() && written[0] != 0xff) {
        written.erase(written.begin());
        ++noise;
      }
      if (written.size() < 8) return;
      const size_t whole = written[2] + 256u * written[3] + 8;
      if (written.size() < whole) return;
      const Bytes bytes(written.begin(), written.begin() + static_cast<long>(whole));
      const Frame got = {static_cast<uint16_t>(written[5] | written[6] << 8),
                         Bytes(written.begin() + 7, written.begin() + static_cast<long>(whole) - 1)};
      if (bytes != frame(got.id, got.payload)) {
        written.erase(written.begin());
        ++noise;
        continue;
      }
      written.erase(written.begin(), written.begin() + static_cast<long>(whole));
      frames.push_back(got);
      if (on_frame) on_frame(got);
    }
  }

  std::vector<Frame> take() {
    EXPECT(written.empty());
    EXPECT_EQUAL(noise, 0u);
    std::vector<Frame> taken;
    taken.swap(frames);
    return taken;
  }
  std::vector<Frame> take(uint16_t id) {
    const std::vector<Frame> all = take();
    std::vector<Frame> taken;
    for (size_t i = 0; i < all.size(); ++i) {
      if (all[i].id == id) taken.push_back(all[i]);
    }
    return taken;
  }
};

// A Hardware with only the four necessary functions: it cannot report the room of its transmitter.
class PlainHardware {
 public:
  void init() { ++line.begun; }
  int read() { return line.read(); }
  void write(uint8_t* bytes, int count) { line.write(bytes, count); }
  unsigned long time() { return line.time(); }

  Line line;
};

// A Hardware with a queue for sent bytes, like a UART, that empties with time.
class QueueingHardware : public PlainHardware {
 public:
  int writable() {
    ++asked;
    if (stuck) {
      ++line.now_ms;
      return 0;
    }
    queued -= queued < bytes_a_look ? queued : bytes_a_look;
    return queue_bytes - queued;
  }
  void write(uint8_t* bytes, int count) {
    EXPECT(count <= queue_bytes - queued);
    queued += count;
    line.write(bytes, count);
  }

  int queue_bytes = 64;
  int bytes_a_look = 1;
  int queued = 0;
  int asked = 0;
  bool stuck = false;
};

// A node on a scripted line. `meet` acts as a host that requests the topics and answers the time request.
template <class Hardware = PlainHardware, int INPUT_SIZE = 512>
struct Board {
  ros::NodeHandle_<Hardware, 25, 25, INPUT_SIZE, 512> node;
  Line& line;

  Board() : line(node.getHardware()->line) { line.now_ms = 1000; }

  void meet(uint32_t host_sec = 1700000000) {
    node.initNode();
    line.send(frame(0));
    EXPECT_EQUAL(node.spinOnce(), ros::SPIN_ERR);
    line.send(time(host_sec));
    EXPECT_EQUAL(node.spinOnce(), ros::SPIN_OK);
    EXPECT(node.connected());
    line.take();
  }
  static Bytes time(uint32_t sec, uint32_t nsec = 0) { return frame(10, Payload().u32(sec).u32(nsec)); }
  std::vector<TopicInfo> announced() {
    std::vector<TopicInfo> infos;
    const std::vector<Frame> frames = line.take();
    for (size_t i = 0; i < frames.size(); ++i) {
      if (frames[i].id < 6) infos.push_back(topicInfo(frames[i]));
    }
    return infos;
  }
};

#endif
