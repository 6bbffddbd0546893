// A line that accepts nothing for a while, with its own clock. Exits with the number of the first check that fails.
#define ROS_NO_PLATFORM
#include <ros.h>
#include <std_msgs/UInt32.h>

class Line {
 public:
  Line() : now_ms_(0), room_(1000), sent_(0), next_(0) {}
  void init() {}
  int read() { return next_ < sizeof request ? request[next_++] : -1; }
  void write(uint8_t*, int count) { sent_ += count; }
  int writable() {
    ++now_ms_;
    return room_;
  }
  unsigned long time() { return now_ms_; }

  unsigned long now_ms_;
  int room_;
  int sent_;

 private:
  // The host's request for the topics.
  static const uint8_t request[8];
  size_t next_;
};
const uint8_t Line::request[8] = {0xff, 0xfe, 0, 0, 0xff, 0, 0, 0xff};

int main() {
  ros::NodeHandle_<Line> nh;
  std_msgs::UInt32 count;
  ros::Publisher counter("count", &count);
  nh.initNode();
  nh.advertise(counter);
  nh.spinOnce();
  Line& line = *nh.getHardware();
  if (!nh.connected() || counter.publish(&count) != 12) return 1;

  // The first frame waits for the line; the others do not wait again.
  line.room_ = 0;
  unsigned long began_ms = line.now_ms_;
  if (counter.publish(&count) != -1) return 2;
  if (line.now_ms_ - began_ms < 90 || line.now_ms_ - began_ms > 130) return 3;
  began_ms = line.now_ms_;
  for (int i = 0; i < 10; ++i) {
    if (counter.publish(&count) != -1) return 4;
  }
  if (line.now_ms_ - began_ms > 20) return 5;

  // Once the line accepts some bytes, the node waits again when the line is full.
  line.room_ = 1;
  line.sent_ = 0;
  if (counter.publish(&count) != 12 || line.sent_ != 12) return 6;
  line.room_ = 0;
  began_ms = line.now_ms_;
  if (counter.publish(&count) != -1 || line.now_ms_ - began_ms < 90) return 7;
  line.room_ = 1000;
  if (counter.publish(&count) != 12) return 8;
  line.room_ = 0;
  began_ms = line.now_ms_;
  if (counter.publish(&count) != -1 || line.now_ms_ - began_ms < 90) return 9;
  return 0;
}
