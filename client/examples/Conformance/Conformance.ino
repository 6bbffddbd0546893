// Conformance: the program that `rostether conformance` checks. It returns texts and numbers. On command, it calls a
// service, gets parameters and logs.
//
// Wiring:  none.
// Try it:  rostether conformance /dev/ttyACM0

#include <ros.h>
#include <std_msgs/Empty.h>
#include <std_msgs/Float64.h>
#include <std_msgs/String.h>
#include <std_msgs/Time.h>
#include <std_msgs/UInt8.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

using std_srvs::SetBool;
using std_srvs::Trigger;

ros::NodeHandle nh;

std_msgs::String text;
std_msgs::Float64 real;
std_msgs::Time moment;
ros::Publisher text_out("conformance/text_out", &text);
ros::Publisher real_out("conformance/real_out", &real);
ros::Publisher pong("conformance/pong", &moment);
ros::ServiceClient<Trigger::Request, Trigger::Response> trigger("conformance/trigger");

void sendText(const char* value) {
  text.data = value;
  text_out.publish(&text);
}

void sendReal(float value) {
  real.data = value;
  real_out.publish(&real);
}

void returnText(const std_msgs::String& message) { text_out.publish(&message); }
void returnReal(const std_msgs::Float64& message) { real_out.publish(&message); }

void sendTime(const std_msgs::Empty&) {
  moment.data = nh.now();
  pong.publish(&moment);
}

void callTrigger() {
  Trigger::Request request;
  Trigger::Response response;
  sendText(trigger.call(request, response) ? response.message : "none");
}

void getInts() {
  int values[2];
  if (!nh.getParam("conformance/ints", values, 2)) return sendText("none");
  sendReal(values[0]);
  sendReal(values[1]);
}

void getFloat() {
  float value;
  if (!nh.getParam("conformance/float", &value)) return sendText("none");
  sendReal(value);
}

void getText() {
  char value[20];
  char* buffer = value;
  sendText(nh.getParam("conformance/text", &buffer) ? value : "none");
}

void log() {
  nh.logdebug("debug");
  nh.loginfo("info");
  nh.logwarn("warn");
  nh.logerror("error");
  nh.logfatal("fatal");
}

// loop() handles the command: a service call or a parameter request inside a callback would keep its message in memory.
uint8_t command = 0;
void keep(const std_msgs::UInt8& message) { command = message.data; }

void obey() {
  const uint8_t kept = command;
  command = 0;
  switch (kept) {
    case 1: return log();
    case 2: return callTrigger();
    case 3: return getInts();
    case 4: return getFloat();
    case 5: return getText();
  }
}

void answer(const SetBool::Request& request, SetBool::Response& response) {
  response.success = request.data;
  response.message = request.data ? "on" : "off";
}

ros::Subscriber<std_msgs::String> text_in("conformance/text_in", &returnText);
ros::Subscriber<std_msgs::Float64> real_in("conformance/real_in", &returnReal);
ros::Subscriber<std_msgs::Empty> ping("conformance/ping", &sendTime);
ros::Subscriber<std_msgs::UInt8> commands("conformance/command", &keep);
ros::ServiceServer<SetBool::Request, SetBool::Response> server("conformance/switch", &answer);

void setup() {
  nh.initNode();
  nh.advertise(text_out);
  nh.advertise(real_out);
  nh.advertise(pong);
  nh.subscribe(text_in);
  nh.subscribe(real_in);
  nh.subscribe(ping);
  nh.subscribe(commands);
  nh.advertiseService(server);
  nh.serviceClient(trigger);
}

void loop() {
  nh.spinOnce();
  obey();
}
