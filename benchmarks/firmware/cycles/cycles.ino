// The cost of the library in cycles: the simulated board counts those between GPIOR2 = 1 and GPIOR2 = 0.
//
// With NEUTRAL_HARDWARE the line is memory and no interrupt runs: the library alone. Without it the line is Serial, and
// its interrupts count too.
#include <nav_msgs/Odometry.h>
#include <ros.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/Range.h>
#include <std_msgs/Empty.h>
#include <std_msgs/Int16.h>
#include <std_msgs/String.h>

#if defined(NEUTRAL_HARDWARE)
static uint8_t arrived[64];
static uint8_t arrived_count, taken_count;
static volatile uint8_t last_sent;

class Memory {
 public:
  void init() {}
  int read() { return taken_count < arrived_count ? arrived[taken_count++] : -1; }
  void write(uint8_t* bytes, int count) { last_sent = bytes[count - 1]; }
  unsigned long time() { return now_ms; }
  unsigned long now_ms = 0;
};
ros::NodeHandle_<Memory> nh;
#else
ros::NodeHandle nh;
#endif

std_msgs::String text;
sensor_msgs::Range range;
sensor_msgs::Imu imu;
nav_msgs::Odometry odometry;
ros::Publisher texts("texts", &text);
ros::Publisher ranges("ranges", &range);
ros::Publisher imus("imus", &imu);
ros::Publisher odometries("odometries", &odometry);

volatile int last_number;
volatile char last_letter;
volatile uint8_t ticks_heard;
void hearNumber(const std_msgs::Int16& message) { last_number = message.data; }
void hearText(const std_msgs::String& message) { last_letter = message.data[0]; }
void hearTick(const std_msgs::Empty&) { ticks_heard = 1; }
ros::Subscriber<std_msgs::Int16> numbers("numbers", &hearNumber);
ros::Subscriber<std_msgs::String> words("words", &hearText);
ros::Subscriber<std_msgs::Empty> ticks("ticks", &hearTick);

static void begin() {
#if defined(NEUTRAL_HARDWARE)
  cli();
#else
  delay(100);  // until all waiting bytes are sent
#endif
  GPIOR2 = 1;
}
static void end() {
  GPIOR2 = 0;
  sei();
}

// Simulates the arrival of a message of `length` bytes on `id`.
static void arrive(uint16_t id, const uint8_t* payload, uint8_t length) {
#if defined(NEUTRAL_HARDWARE)
  uint8_t sum = 255 - id - (id >> 8);
  const uint8_t head[] = {0xff, 0xfe, length, 0, (uint8_t)(255 - length), (uint8_t)id, (uint8_t)(id >> 8)};
  memcpy(arrived, head, 7);
  for (uint8_t i = 0; i < length; ++i) sum -= arrived[7 + i] = payload[i];
  arrived[7 + length] = sum;
  arrived_count = length + 8;
  taken_count = 0;
#else
  (void)id, (void)payload;
  while (Serial.available() < length + 8) continue;
#endif
}

void setup() {
#if !defined(NEUTRAL_HARDWARE)
  nh.getHardware()->setBaud(1000000);
#endif
  nh.initNode();
  nh.subscribe(numbers);
  nh.subscribe(words);
  nh.subscribe(ticks);
  nh.advertise(texts);
  nh.advertise(ranges);
  nh.advertise(imus);
  nh.advertise(odometries);
  // The first spinOnce of a board, and its answer to a host that requests the topics.
  begin();
  nh.spinOnce();
  end();
  arrive(0, nullptr, 0);
  begin();
  nh.spinOnce();
  end();

  text.data = "hello world!";
  range.header.frame_id = "/ultrasound";
  range.range = 1.5;
  imu.header.frame_id = "imu";
  imu.orientation.w = 0.5;
  imu.linear_acceleration.z = 9.81;
  odometry.header.frame_id = "odom";
  odometry.child_frame_id = "base_link";
  odometry.pose.pose.position.x = 1.25;
  // Numbers other than zero take more cycles.
  for (uint8_t i = 0; i < 9; ++i) {
    imu.orientation_covariance[i] = imu.angular_velocity_covariance[i] = imu.linear_acceleration_covariance[i] = 0.01 * (i + 1);
  }
  for (uint8_t i = 0; i < 36; ++i) odometry.pose.covariance[i] = odometry.twist.covariance[i] = 0.1 * (i + 1);

  begin();
  texts.publish(&text);
  end();
  begin();
  ranges.publish(&range);
  end();
  begin();
  imus.publish(&imu);
  end();
  begin();
  odometries.publish(&odometry);
  end();
  nh.spinOnce();
  begin();
  nh.spinOnce();
  end();
  const uint8_t number[] = {0x34, 0x12};
  arrive(numbers.id_, number, sizeof number);
  begin();
  nh.spinOnce();
  end();
  arrive(ticks.id_, nullptr, 0);
  begin();
  nh.spinOnce();
  end();
  const uint8_t word[] = {12, 0, 0, 0, 'h', 'e', 'l', 'l', 'o', ' ', 'w', 'o', 'r', 'l', 'd', '!'};
  arrive(words.id_, word, sizeof word);
  begin();
  nh.spinOnce();
  end();
}

void loop() {}
