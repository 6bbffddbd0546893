// A robot with ros::MulticastCommand on loopback, in the group 239.255.82.83. It prints one action per line: "drive
// DIRECTION SPEED", "halt" or "open". Its socket receives nothing after STALL_AFTER datagrams, until it is opened
// again:
//   multicast_robot PORT [STALL_AFTER]
// The same with ros::MulticastTopic:
//   multicast_robot PORT bare
// Robot 3 of group 1 without a network. Each line of the standard input is a time in milliseconds and a datagram in
// hexadecimal. The robot prints the datagram's demand (0 nothing, 1 drive, 2 stop, 3 stop after silence), and the
// status that answers it in hexadecimal, or -:
//   multicast_robot < LINES
#include <stdio.h>
#include <stdlib.h>

#include <Ethernet.h>
#include <EthernetUdp.h>
#include <arduino_control/ArduinoControl.h>
#include <ros/multicast_command.h>
#include <ros/multicast_topic.h>

HardwareSerial Serial;
EthernetClass Ethernet;
static int stall_after;

// A socket with the multicast of the official Ethernet library. As on an ESP32, a datagram must be read before the next
// one is received.
class DeafUdp : public EthernetUDP {
 public:
  DeafUdp() : heard_(0) {}
  uint8_t beginMulticast(IPAddress group, uint16_t port) {
    heard_ = 0;
    while (available() > 0) read();
    printf("open\n");
    return EthernetUDP::beginMulticast(group, port);
  }
  int parsePacket() {
    if (available() > 0) return 0;
    const int size = EthernetUDP::parsePacket();
    return size > 0 && stall_after && ++heard_ > stall_after ? 0 : size;
  }

 private:
  int heard_;
};

static void drive(const arduino_control::ArduinoControl& command) { printf("drive %g %g\n", command.dir, command.speed); }
static void halt() { printf("halt\n"); }
const ros::FleetKey KEY("30313233343536373839616263646566");
static ros::MulticastCommand<arduino_control::ArduinoControl, DeafUdp> commands(&drive, &halt, KEY);

static ros::MulticastTopic<arduino_control::ArduinoControl, DeafUdp> topic(&drive, &halt, 200);

template <class Commands>
static void obey(Commands& by, const char* port) {
  by.begin(IPAddress(239, 255, 82, 83), static_cast<uint16_t>(atoi(port)));
  for (;;) {
    by.spinOnce();
    delay(2);
  }
}

static void obeyLines() {
  // The number is the kind of arduino_control/ArduinoControl.
  ros::CommandReceiver robot(KEY, 0x4ccb2875);
  robot.setRobot(3, 2);
  robot.setSignal(-61);
  unsigned now_ms;
  char hex[4096];
  while (scanf("%u %4095s", &now_ms, hex) == 2) {
    alignas(8) uint8_t frame[2048];
    size_t size = 0;
    for (unsigned byte; sscanf(hex + 2 * size, "%2x", &byte) == 1; ++size) frame[size] = static_cast<uint8_t>(byte);
    if (robot.expired(static_cast<uint16_t>(now_ms))) printf("3 -\n");
    const int demand = robot.receive(frame, static_cast<uint16_t>(size), static_cast<uint16_t>(now_ms));
    const bool obeys = demand & ros::CommandReceiver::OBEY;
    // 10.0.0.1:5000
    if (obeys) robot.setHolder(0x0100000a, 5000);
    printf("%d ", obeys ? robot.isMoving() ? 1 : 2 : 0);
    if (demand & ros::CommandReceiver::ANSWER) {
      robot.answer(frame);
      for (size_t i = 0; i < ros::CommandReceiver::STATUS_BYTES; ++i) printf("%02x", frame[i]);
    } else {
      putchar('-');
    }
    putchar('\n');
  }
}

int main(int count, char** arguments) {
  setvbuf(stdout, nullptr, _IOLBF, 0);
  if (count == 1) {
    obeyLines();
    return 0;
  }
  if (count > 2 && strcmp(arguments[2], "bare") == 0) obey(topic, arguments[1]);
  if (count > 2) stall_after = atoi(arguments[2]);
  commands.setRobot(3);
  obey(commands, arguments[1]);
}
