// A roscpp node for the interoperability tests and benchmarks: one program, one role per run.
//   listen TOPIC COUNT        std_msgs/String; prints each text, ends after COUNT
//   count TOPIC COUNT IDLE_S  any type, tcp_nodelay; ends after COUNT messages or IDLE_S without one;
//                             prints "count bytes seconds cpu_seconds sum"
//   talk TOPIC COUNT HZ       std_msgs/String "message N"; HZ 0 floods; waits for a subscriber first
//   flood TOPIC COUNT BYTES HZ WAIT_S  std_msgs/String of BYTES bytes on the wire; WAIT_S before the first
//   latch TOPIC TEXT          latched std_msgs/String, until stopped
//   serve SERVICE             std_srvs/SetBool, until stopped
//   call SERVICE true|false COUNT   persistent when COUNT > 1; prints "success message" for each
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>
#include <sys/resource.h>

#include <cstdio>
#include <string>

struct Raw {
  typedef boost::shared_ptr<Raw const> ConstPtr;
  std::vector<uint8_t> data;
};

namespace ros {
namespace message_traits {
template <> struct MD5Sum<Raw> {
  static const char* value() { return "*"; }
  static const char* value(const Raw&) { return "*"; }
};
template <> struct DataType<Raw> {
  static const char* value() { return "*"; }
  static const char* value(const Raw&) { return "*"; }
};
template <> struct Definition<Raw> {
  static const char* value() { return ""; }
  static const char* value(const Raw&) { return ""; }
};
}  // namespace message_traits
namespace serialization {
template <> struct Serializer<Raw> {
  template <typename Stream> inline static void read(Stream& stream, Raw& message) {
    message.data.assign(stream.getData(), stream.getData() + stream.getLength());
  }
  template <typename Stream> inline static void write(Stream&, const Raw&) {}
  inline static uint32_t serializedLength(const Raw& message) { return message.data.size(); }
};
}  // namespace serialization
}  // namespace ros

static long wanted = 0;
static long received = 0;
static long received_bytes = 0;
static uint64_t sum = 0;
static ros::WallTime first, last;

static void onText(const std_msgs::String::ConstPtr& message) {
  std::printf("%s\n", message->data.c_str());
  std::fflush(stdout);
  if (++received >= wanted) ros::shutdown();
}

static void onRaw(const Raw::ConstPtr& message) {
  last = ros::WallTime::now();
  if (received == 0) first = last;
  received_bytes += message->data.size();
  for (size_t i = 0; i < message->data.size(); i += 16) sum += message->data[i];
  if (++received >= wanted) ros::shutdown();
}

static bool onSetBool(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  response.success = request.data;
  response.message = request.data ? "on" : "off";
  return true;
}

static double cpuSeconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_utime.tv_sec + usage.ru_stime.tv_sec + (usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) * 1e-6;
}

static void waitForSubscriber(const ros::Publisher& publisher) {
  while (ros::ok() && publisher.getNumSubscribers() == 0) ros::WallDuration(0.01).sleep();
}

static void publishAll(const ros::Publisher& publisher, long count, double hz, size_t bytes) {
  std_msgs::String message;
  ros::WallTime start = ros::WallTime::now();
  for (long i = 0; ros::ok() && i < count; ++i) {
    message.data = "message " + std::to_string(i);
    if (bytes > 4) message.data.resize(bytes - 4, '.');
    publisher.publish(message);
    if (hz > 0) {
      ros::WallTime due = start + ros::WallDuration((i + 1) / hz);
      if (due > ros::WallTime::now()) ros::WallTime::sleepUntil(due);
    }
  }
}

int main(int argc, char** argv) {
  ros::init(argc, argv, "roscpp_peer", ros::init_options::AnonymousName);
  if (argc < 3) return 2;
  std::string role = argv[1], name = argv[2];
  ros::NodeHandle node;
  if (role == "listen") {
    wanted = std::atol(argv[3]);
    ros::Subscriber subscriber = node.subscribe(name, 1000, onText, ros::TransportHints().tcpNoDelay());
    ros::spin();
  } else if (role == "count") {
    wanted = std::atol(argv[3]);
    double idle = argc > 4 ? std::atof(argv[4]) : 5.0;
    ros::Subscriber subscriber = node.subscribe(name, 0, onRaw, ros::TransportHints().tcpNoDelay());
    ros::WallTime started = ros::WallTime::now();
    while (ros::ok()) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.05));
      ros::WallTime since = received ? last : started;
      if (received && (ros::WallTime::now() - since).toSec() > idle) break;
    }
    std::printf("%ld %ld %.6f %.3f %llu\n", received, received_bytes, (last - first).toSec(), cpuSeconds(),
                static_cast<unsigned long long>(sum));
  } else if (role == "talk" || role == "flood") {
    bool flood = role == "flood";
    ros::Publisher publisher = node.advertise<std_msgs::String>(name, flood ? 0 : 1000);
    waitForSubscriber(publisher);
    if (flood) ros::WallDuration(argc > 6 ? std::atof(argv[6]) : 0.0).sleep();
    publishAll(publisher, std::atol(argv[3]), std::atof(argv[flood ? 5 : 4]), flood ? std::atol(argv[4]) : 0);
    std::printf("sent %s %.3f\n", argv[3], cpuSeconds());
    std::fflush(stdout);
    while (ros::ok() && publisher.getNumSubscribers() > 0) ros::WallDuration(0.02).sleep();
  } else if (role == "latch") {
    ros::Publisher publisher = node.advertise<std_msgs::String>(name, 1, true);
    std_msgs::String message;
    message.data = argv[3];
    publisher.publish(message);
    ros::spin();
  } else if (role == "serve") {
    ros::ServiceServer server = node.advertiseService(name, onSetBool);
    std::printf("serving\n");
    std::fflush(stdout);
    ros::spin();
  } else if (role == "call") {
    long count = argc > 4 ? std::atol(argv[4]) : 1;
    ros::ServiceClient client = node.serviceClient<std_srvs::SetBool>(name, count > 1);
    if (!client.waitForExistence(ros::Duration(10.0))) return 1;
    for (long i = 0; i < count; ++i) {
      std_srvs::SetBool call;
      call.request.data = std::string(argv[3]) == "true";
      if (!client.call(call)) return 1;
      std::printf("%d %s\n", call.response.success, call.response.message.c_str());
    }
  } else {
    return 2;
  }
  return 0;
}
