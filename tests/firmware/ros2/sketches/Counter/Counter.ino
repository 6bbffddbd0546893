// Counts fifty times a second, repeats numbers that it hears, and answers a service.
#include <ros.h>
#include <std_msgs/UInt32.h>
#include <std_srvs/SetBool.h>

using std_srvs::SetBool;

ros::NodeHandle nh;

std_msgs::UInt32 number;
ros::Publisher count("count", &number);
std_msgs::UInt32 again;
ros::Publisher repeated("repeated", &again);

void repeat(const std_msgs::UInt32& heard) { repeated.publish(&heard); }
ros::Subscriber<std_msgs::UInt32> say("say", &repeat);

void answer(const SetBool::Request& request, SetBool::Response& response) { response.success = request.data; }
ros::ServiceServer<SetBool::Request, SetBool::Response> server("switch", &answer);

unsigned long due_ms = 0;

void setup() {
  nh.initNode();
  nh.advertise(count);
  nh.advertise(repeated);
  nh.subscribe(say);
  nh.advertiseService(server);
}

void loop() {
  nh.spinOnce();
  if (!nh.connected() || static_cast<long>(millis() - due_ms) < 0) return;
  due_ms = millis() + 20;
  number.data++;
  count.publish(&number);
}
